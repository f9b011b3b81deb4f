# Text files compiled into the library: fluovox_embed(FILE...) in a module's folder notes them, and
# fluovox_write_embedded(TARGET) makes the one source that core/embedded_text.h promises. A file's name in the
# program is its path below src/fluovox (of others: below the project). Run as a script (cmake -P) this same file writes that source.
if(CMAKE_SCRIPT_MODE_FILE)
  string(REPLACE "|" ";" files "${FILES}")
  set(entries "")
  foreach(file IN LISTS files)
    file(READ "${ROOT}/${file}" text)
    string(REGEX REPLACE "^src/fluovox/" "" name "${file}")
    string(APPEND entries "    Entry{\"${name}\", R\"embedded(${text})embedded\"},\n")
  endforeach()
  file(WRITE "${OUTPUT}" "// Written by cmake/FluovoxEmbed.cmake.
#include \"fluovox/core/embedded_text.h\"

#include <stdexcept>
#include <string>

namespace fluovox {
namespace {

struct Entry {
    std::string_view name;
    std::string_view text;
};

constexpr Entry kEntries[] = {
${entries}};

}  // namespace

std::string_view embedded_text(std::string_view name) {
    for (const Entry& entry : kEntries) {
        if (entry.name == name) return entry.text;
    }
    throw std::logic_error(\"no embedded text \" + std::string(name));
}

}  // namespace fluovox
")
  return()
endif()

function(fluovox_embed)
  foreach(file IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_property(GLOBAL APPEND PROPERTY FLUOVOX_EMBEDDED ${file})
  endforeach()
endfunction()

function(fluovox_write_embedded target)
  get_property(files GLOBAL PROPERTY FLUOVOX_EMBEDDED)
  set(root ${PROJECT_SOURCE_DIR})
  set(script ${PROJECT_SOURCE_DIR}/cmake/FluovoxEmbed.cmake)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/embedded_text.cpp)
  list(TRANSFORM files PREPEND ${root}/ OUTPUT_VARIABLE inputs)
  list(JOIN files "|" joined)
  add_custom_command(OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DFILES=${joined}" -DROOT=${root} -DOUTPUT=${output} -P ${script}
    DEPENDS ${script} ${inputs}
    COMMENT "Embedding the tables" VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()
