# The check of names must find a type that is defined twice, and accept declarations, uses and nested types.
cmake_minimum_required(VERSION 3.25)
include(${CMAKE_CURRENT_LIST_DIR}/expect.cmake)
file(REMOVE_RECURSE ${WORK_DIR})
file(WRITE ${WORK_DIR}/src/fluovox/core/one.h "struct Point;\nstruct Point {\n    struct Part {\n    };\n};\nenum class Kind { A };\n")
file(WRITE ${WORK_DIR}/src/fluovox/volume/two.h "struct Point;\nclass Line : Base<Point> {\n    struct Part {\n    };\n};\n")

expect(0 "^$")
foreach(second IN ITEMS "struct Point {" "class Point final {" "class Point : public Base {" "enum class Kind {")
  file(WRITE ${WORK_DIR}/src/fluovox/volume/three.h "${second}\n};\n")
  expect(1 "three.h: (Point|Kind) is another type in src/fluovox/core/one.h|one.h: (Point|Kind) is another type in .*three.h")
endforeach()
