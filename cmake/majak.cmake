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

# What most sources read first, read once; a source still includes all that it uses, which builds
# with CMAKE_DISABLE_PRECOMPILE_HEADERS (./dev sanitize, ./dev lint) find out.
set(majak_precompiled <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <optional> <span>
  <string> <string_view> <utility> <variant> <vector> <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/LU>)
# majak_precompile(target first header...): the headers of target first, which all its like share.
function(majak_precompile target first)
  if(target STREQUAL first)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  else()
    target_precompile_headers(${target} REUSE_FROM ${first})
  endif()
  # For ccache, which would not see what the precompiled headers hold.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
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
    majak_precompile(majak_${name} majak_core ${majak_precompiled})
  else()
    add_library(majak_${name} INTERFACE)
    target_include_directories(majak_${name} INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include>)
    target_link_libraries(majak_${name} INTERFACE ${lower} ${L_PUBLIC})
  endif()
  set_target_properties(majak_${name} PROPERTIES EXPORT_NAME ${name})
  add_library(majak::${name} ALIAS majak_${name})
endfunction()
