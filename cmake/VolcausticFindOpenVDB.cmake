# Finds OpenVDB for the build of volcaustic and, installed beside volcausticConfig.cmake, for everybody who uses it.
# Debian's FindOpenVDB.cmake sets BUILD_SHARED_LIBS and other variables in its caller's scope; a function keeps them in.
# The module sits beside the library, not on CMake's default module path.
function(volcaustic_find_openvdb found)
  find_path(VOLCAUSTIC_OPENVDB_MODULE_DIR FindOpenVDB.cmake
            PATH_SUFFIXES lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB lib/cmake/OpenVDB lib64/cmake/OpenVDB
            DOC "Folder of OpenVDB's own find module")
  mark_as_advanced(VOLCAUSTIC_OPENVDB_MODULE_DIR)
  if(VOLCAUSTIC_OPENVDB_MODULE_DIR)
    list(APPEND CMAKE_MODULE_PATH ${VOLCAUSTIC_OPENVDB_MODULE_DIR})
  endif()
  find_package(OpenVDB COMPONENTS openvdb)
  set(${found} ${OpenVDB_FOUND} PARENT_SCOPE)
endfunction()
