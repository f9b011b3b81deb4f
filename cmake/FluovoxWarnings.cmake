# Warnings and machine options are a build-tree concern: never exported to whoever links fluovox.
add_library(fluovox_warnings INTERFACE)
target_compile_options(fluovox_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wconversion -Wdouble-promotion
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>  # g++ 12 sees ghosts in std::string's operator+ (GCC bug 105651)
  $<$<BOOL:${FLUOVOX_WERROR}>:-Werror>
  $<$<BOOL:${FLUOVOX_NATIVE}>:-march=native>)
