# The check of names must find a type that is defined twice, and accept declarations, uses and nested types.
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE ${WORK_DIR})
file(WRITE ${WORK_DIR}/src/fluovox/core/one.h "struct Point;\nstruct Point {\n    struct Part {\n    };\n};\nenum class Kind { A };\n")
file(WRITE ${WORK_DIR}/src/fluovox/volume/two.h "struct Point;\nclass Line : Base<Point> {\n    struct Part {\n    };\n};\n")

function(check expected_result expected_message)
  execute_process(COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${WORK_DIR} -P ${SCRIPT}
    RESULT_VARIABLE result ERROR_VARIABLE message OUTPUT_QUIET)
  if(NOT result EQUAL expected_result OR NOT message MATCHES "${expected_message}")
    message(FATAL_ERROR "expected ${expected_result} and \"${expected_message}\", got ${result} and:\n${message}")
  endif()
endfunction()

check(0 "^$")
foreach(second IN ITEMS "struct Point {" "class Point final {" "class Point : public Base {" "enum class Kind {")
  file(WRITE ${WORK_DIR}/src/fluovox/volume/three.h "${second}\n};\n")
  check(1 "three.h: (Point|Kind) is another type in src/fluovox/core/one.h|one.h: (Point|Kind) is another type in .*three.h")
endforeach()
