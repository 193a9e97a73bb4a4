# What `cmake --install` puts down: the library, its public headers, find_package and pkg-config files. The program
# adds itself in tools/.
include(CMakePackageConfigHelpers)

install(TARGETS volcaustic EXPORT volcausticTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS volcaustic_imageio LIBRARY DESTINATION ${VOLCAUSTIC_MODULE_DIR})
install(DIRECTORY libvolcaustic/include/volcaustic DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})

# find_package(volcaustic CONFIG)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/volcaustic)
get_target_property(VOLCAUSTIC_LIBRARY_TYPE volcaustic TYPE)
configure_package_config_file(cmake/volcausticConfig.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/volcausticConfig.cmake
                              INSTALL_DESTINATION ${package_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/volcausticConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(EXPORT volcausticTargets NAMESPACE volcaustic:: DESTINATION ${package_dir})
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/volcausticConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/volcausticConfigVersion.cmake
              cmake/VolcausticFindBullet.cmake cmake/VolcausticFindOpenVDB.cmake
        DESTINATION ${package_dir})

# pkg-config. OpenVDB and OpenMesh have no usable .pc file in Debian, so they are named as libraries. A static library
# needs all of its dependencies on the link line, a shared one only what its headers name.
function(volcaustic_pc_library out target name)
  get_target_property(location ${target} LOCATION)
  cmake_path(GET location PARENT_PATH folder)
  if(NOT folder IN_LIST CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES)
    set(${out} "${${out}} -L${folder}")
  endif()
  set(${out} "${${out}} -l${name}" PARENT_SCOPE)
endfunction()

# Relative to the file itself: an installed folder can be moved, and --prefix may be chosen at install time.
file(RELATIVE_PATH VOLCAUSTIC_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
set(VOLCAUSTIC_PC_REQUIRES "Imath tbb")
set(VOLCAUSTIC_PC_LIBS "")
volcaustic_pc_library(VOLCAUSTIC_PC_LIBS OpenVDB::openvdb openvdb)
if(VOLCAUSTIC_LIBRARY_TYPE STREQUAL "STATIC_LIBRARY")
  string(APPEND VOLCAUSTIC_PC_REQUIRES " OpenEXR blosc zlib")
  volcaustic_pc_library(VOLCAUSTIC_PC_LIBS OpenMeshCore OpenMeshCore)
  foreach(name BulletDynamics BulletCollision LinearMath)
    volcaustic_pc_library(VOLCAUSTIC_PC_LIBS Bullet::${name} ${name})
  endforeach()
  if(VOLCAUSTIC_HAS_CUDA)
    volcaustic_pc_library(VOLCAUSTIC_PC_LIBS CUDA::cudart_static cudart_static)
    string(APPEND VOLCAUSTIC_PC_LIBS " -lrt")
  endif()
  string(APPEND VOLCAUSTIC_PC_LIBS " -ldl -pthread -Wl,-rpath,\${libdir}/volcaustic")
endif()
configure_file(cmake/volcaustic.pc.in ${CMAKE_CURRENT_BINARY_DIR}/volcaustic.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/volcaustic.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
