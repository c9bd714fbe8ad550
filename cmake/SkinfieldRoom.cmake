# skinfield_room(NAME [ROOMS above...] [LINK PUBLIC|PRIVATE targets...]): one library from
# src/NAME/*.cpp that sees the public headers and links only the rooms named.
add_library(skinfield_options INTERFACE)
target_compile_options(skinfield_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Werror
  $<$<CONFIG:Release>:-O3 -fno-math-errno>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees overlaps in std::string that are not there (its bug 105329). clang-tidy reads these
  # options too and does not know the name.
  target_compile_options(skinfield_options INTERFACE -Wno-unknown-warning-option -Wno-restrict)
endif()
if(SKINFIELD_NATIVE)
  target_compile_options(skinfield_options INTERFACE -march=native)
endif()
if(SKINFIELD_SANITIZE)
  target_compile_options(skinfield_options INTERFACE -fsanitize=${SKINFIELD_SANITIZE}
    -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(skinfield_options INTERFACE -fsanitize=${SKINFIELD_SANITIZE})
endif()
if(SKINFIELD_SANITIZE MATCHES thread)
  # TBB's inlined headers are not for the sanitizer to judge: see src/base/loop_order.h.
  set_source_files_properties(${PROJECT_SOURCE_DIR}/src/base/parallel.cpp PROPERTIES
    COMPILE_OPTIONS -fno-sanitize=thread COMPILE_DEFINITIONS SKINFIELD_THREAD_SANITIZER)
endif()
set(SKINFIELD_TARGETS "" CACHE INTERNAL "")

function(skinfield_room name)
  cmake_parse_arguments(ROOM "" "" "ROOMS;LINK" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  set(target skinfield_${name})
  if(sources)
    add_library(${target} STATIC ${sources})
    set(scope PUBLIC)
    target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:skinfield_options>)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(skinfield::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_compile_features(${target} ${scope} cxx_std_20)
  foreach(room ${ROOM_ROOMS})
    target_link_libraries(${target} ${scope} skinfield::${room})
  endforeach()
  if(sources AND ROOM_LINK)
    target_link_libraries(${target} ${ROOM_LINK})
  endif()
  set(SKINFIELD_TARGETS ${SKINFIELD_TARGETS} ${target} CACHE INTERNAL "")
endfunction()
