# Most of a build is reading headers. What most sources read is read once for each set of compiler flags, and sources
# that share the costliest headers are compiled together. Each source includes what it uses all the same and would
# compile alone: the presets for development do that, and clang-tidy goes by them.
option(FLUOVOX_EACH_ALONE "Compile each source on its own: no precompiled headers, none compiled together" OFF)

# For what leaves the work to the library: a quarter off its compile time.
set(FLUOVOX_QUICKLY_COMPILED $<$<CONFIG:Release>:-O1>)

# g++ 12 forgets what is a system header once it is precompiled, and sees ghosts there (GCC bugs 105651, 105329). Who
# wants these warnings of a release asks for FLUOVOX_EACH_ALONE.
set(haunted $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow>)

# Reads the standard headers that are most in use, {fmt}'s and these, once for the target.
function(fluovox_precompile target)
  if(NOT FLUOVOX_EACH_ALONE)
    target_compile_options(${target} PRIVATE ${haunted})
    target_precompile_headers(${target} PRIVATE
      <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <numbers> <optional>
      <span> <stdexcept> <string> <string_view> <utility> <variant> <vector> <fmt/format.h> ${ARGN})
  endif()
endfunction()

# Takes those of another target, which must have the same options.
function(fluovox_precompile_as target other)
  if(NOT FLUOVOX_EACH_ALONE)
    target_compile_options(${target} PRIVATE ${haunted})
    target_precompile_headers(${target} REUSE_FROM ${other})
  endif()
endfunction()

# Compiles sources of the calling folder as one: so their unnamed namespaces are one, too.
function(fluovox_compile_together target name)
  if(NOT FLUOVOX_EACH_ALONE)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
    set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${name})
  endif()
endfunction()
