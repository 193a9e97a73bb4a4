# Finds Bullet's rigid bodies for the build of volcaustic and, installed beside volcausticConfig.cmake, for everybody who links
# the static library. Bullet's own package names its libraries without a folder, relative to a prefix that it does not have to
# have been installed to, so they are looked for.
function(volcaustic_find_bullet found)
  find_path(VOLCAUSTIC_BULLET_INCLUDE_DIR btBulletDynamicsCommon.h PATH_SUFFIXES bullet DOC "Bullet's headers")
  set(missing "")
  # In the order in which a linker needs them.
  foreach(name BulletDynamics BulletCollision LinearMath)
    find_library(VOLCAUSTIC_${name}_LIBRARY ${name} DOC "Bullet")
    mark_as_advanced(VOLCAUSTIC_${name}_LIBRARY)
    if(NOT VOLCAUSTIC_${name}_LIBRARY)
      list(APPEND missing ${name})
    elseif(NOT TARGET Bullet::${name})
      add_library(Bullet::${name} UNKNOWN IMPORTED GLOBAL)
      set_target_properties(Bullet::${name} PROPERTIES IMPORTED_LOCATION ${VOLCAUSTIC_${name}_LIBRARY})
    endif()
  endforeach()
  if(VOLCAUSTIC_BULLET_INCLUDE_DIR AND NOT missing)
    set(${found} TRUE PARENT_SCOPE)
  else()
    set(${found} FALSE PARENT_SCOPE)
  endif()
endfunction()
