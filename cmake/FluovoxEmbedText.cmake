# Text files as constants of the library, so that the program needs no data folder beside it.
#
#   fluovox_embed_text(NAME kConstant FILE path OUTPUT variable)
#
# writes a source with `extern const char* const kConstant` in namespace fluovox and puts its path in `variable`.
# An edited file takes effect at the next build.
function(fluovox_embed_text)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "NAME;FILE;OUTPUT" "")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${arg_FILE})
  file(READ ${arg_FILE} text)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${arg_NAME}.cpp)
  file(CONFIGURE OUTPUT ${source} @ONLY CONTENT "// Made from a data file by the build.
namespace fluovox {
extern const char* const @arg_NAME@;
const char* const @arg_NAME@ = R\"text(@text@)text\";
}  // namespace fluovox
")
  set(${arg_OUTPUT} ${source} PARENT_SCOPE)
endfunction()
