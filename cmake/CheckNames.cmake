# No two headers of src/fluovox define types of one name: both would be one to the linker, which takes the functions of
# either for both.
#   cmake -DSOURCE_DIR=<root of the project> -P cmake/CheckNames.cmake
# Prints every second definition and fails; silent when all is well.
cmake_minimum_required(VERSION 3.25)

set(offences "")
file(GLOB_RECURSE headers RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/src/fluovox/*.h)
foreach(header IN LISTS headers)
  # In classes and functions they are indented, and have names of their own.
  file(STRINGS ${SOURCE_DIR}/${header} lines REGEX "^(struct|class|enum class|enum|union) [A-Za-z_0-9]+( final)?( : [^;]*)? {")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^(enum class|[a-z]+) ([A-Za-z_0-9]+).*" "\\2" name "${line}")
    if(DEFINED home_of_${name})
      list(APPEND offences "${header}: ${name} is another type in ${home_of_${name}}")
    endif()
    set(home_of_${name} ${header})
  endforeach()
endforeach()

if(offences)
  list(JOIN offences "\n" offences)
  message("${offences}")
  message(FATAL_ERROR "types of one name")
endif()
