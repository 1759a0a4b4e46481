# The package `wireloom`: targets wireloom::wireloom (shared) and wireloom::static.
get_filename_component(wireloom_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET wireloom::wireloom)
  add_library(wireloom::wireloom SHARED IMPORTED)
  set_target_properties(wireloom::wireloom PROPERTIES
    IMPORTED_LOCATION "${wireloom_prefix}/lib/libwireloom.so.@VERSION@"
    IMPORTED_SONAME "libwireloom.so.@SONAME@"
    INTERFACE_INCLUDE_DIRECTORIES "${wireloom_prefix}/include")
  add_library(wireloom::static STATIC IMPORTED)
  set_target_properties(wireloom::static PROPERTIES
    IMPORTED_LOCATION "${wireloom_prefix}/lib/libwireloom.a"
    INTERFACE_INCLUDE_DIRECTORIES "${wireloom_prefix}/include"
    INTERFACE_LINK_LIBRARIES "@LIBRARIES@")
endif()
unset(wireloom_prefix)
