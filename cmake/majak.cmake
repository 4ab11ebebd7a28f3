# One folder = one target = one namespace.

add_library(majak_flags INTERFACE)
target_compile_options(majak_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wno-sign-conversion
  # Same bytes on every x86-64: no contraction into fused multiply-adds, whatever the clone.
  -ffp-contract=off -fno-math-errno)
if(MAJAK_WERROR)
  target_compile_options(majak_flags INTERFACE -Werror)
endif()
if(MAJAK_SANITIZE)
  target_compile_options(majak_flags INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  target_link_options(majak_flags INTERFACE -fsanitize=address,undefined)
endif()

set_property(GLOBAL PROPERTY MAJAK_LAYERS "")

# majak_precompile(target header...): what most of its sources read first, read once; REUSE_FROM other: what that one has
# read. Takes half of the compiler's time away. The presets lint, sanitize and fuzz do without, so that a missing include is found.
function(majak_precompile target)
  if(ARGV1 STREQUAL "REUSE_FROM")
    target_precompile_headers(${target} ${ARGN})
  else()
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
  # For ccache, which would not see what the precompiled headers hold.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
endfunction()

include(cmake/together.cmake)

# majak_together(target...): its sources, six at a time, as one; where together.cmake has lines for the target, those lines, each
# as one. Their unnamed namespaces must not name two things alike.
function(majak_together)
  if(NOT MAJAK_TOGETHER)
    return()
  endif()
  foreach(target IN LISTS ARGN)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
    if(NOT DEFINED MAJAK_TOGETHER_${target})
      continue()
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
    get_target_property(sources ${target} SOURCES)
    set(number 0)
    foreach(line IN LISTS MAJAK_TOGETHER_${target})
      math(EXPR number "${number} + 1")
      string(REPLACE " " ";" names "${line}")
      foreach(name IN LISTS names)
        set(found ${sources})
        list(FILTER found INCLUDE REGEX "/${name}\\.cpp$")
        set_source_files_properties(${found} PROPERTIES UNITY_GROUP ${number})
      endforeach()
    endforeach()
  endforeach()
endfunction()

# majak_layer(name USES lower... PUBLIC lib... PRIVATE lib...): the library of folder majak/<name>.
function(majak_layer name)
  cmake_parse_arguments(L "" "" "USES;PUBLIC;PRIVATE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/majak/${name}/*.cpp)
  set_property(GLOBAL APPEND PROPERTY MAJAK_LAYERS majak_${name})
  set(lower ${L_USES})
  list(TRANSFORM lower PREPEND majak_)
  if(sources)
    add_library(majak_${name} STATIC ${sources})
    target_include_directories(majak_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include>)
    target_link_libraries(majak_${name} PUBLIC ${lower} ${L_PUBLIC} PRIVATE ${L_PRIVATE} $<BUILD_INTERFACE:majak_flags>)
    target_compile_features(majak_${name} PUBLIC cxx_std_20)
    if(name STREQUAL core)
      majak_precompile(majak_core <Eigen/Core> <Eigen/Geometry> <Eigen/LU> <algorithm> <array> <cmath> <functional> <map> <memory>
        <optional> <span> <string> <string_view> <variant> <vector>)
    else()
      majak_precompile(majak_${name} REUSE_FROM majak_core)
    endif()
  else()
    add_library(majak_${name} INTERFACE)
    target_include_directories(majak_${name} INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include>)
    target_link_libraries(majak_${name} INTERFACE ${lower} ${L_PUBLIC})
  endif()
  set_target_properties(majak_${name} PROPERTIES EXPORT_NAME ${name})
  add_library(majak::${name} ALIAS majak_${name})
endfunction()
