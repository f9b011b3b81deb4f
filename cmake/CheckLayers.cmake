# Holds the modules of src/fluovox to their order, and keeps heavy libraries out of public headers.
#   cmake -DSOURCE_DIR=<root of the project> -P cmake/CheckLayers.cmake
# Prints every offending line as file:line and fails; silent when all is well.
cmake_minimum_required(VERSION 3.25)

# A module may include itself and what stands here.
set(may_include_core "")
set(may_include_spectral core)
set(may_include_volume core spectral)
set(may_include_medium core spectral volume)
set(may_include_voxelize core spectral volume medium)   # used by tools only
set(may_include_specimen core spectral volume medium voxelize)  # used by tools only
set(may_include_optics core spectral volume medium)
set(may_include_image core spectral volume medium optics)
set(may_include_scene core spectral volume medium optics image)
set(may_include_transport core spectral volume medium optics image scene)

# Public headers are those that a module's CMakeLists.txt lists; they show none of these.
set(hidden_libraries "openvdb/|tbb/|oneapi/|toml\\+\\+/|nlohmann/|OpenEXR/|Imath/|Imf|assimp/|png\\.h|tiff")

set(offences "")
file(GLOB modules LIST_DIRECTORIES true RELATIVE ${SOURCE_DIR}/src/fluovox ${SOURCE_DIR}/src/fluovox/*)
foreach(module IN LISTS modules)
  if(NOT IS_DIRECTORY ${SOURCE_DIR}/src/fluovox/${module})
    continue()
  endif()
  if(NOT DEFINED may_include_${module})
    list(APPEND offences "src/fluovox/${module}: a module without a place in the order of cmake/CheckLayers.cmake")
    continue()
  endif()
  set(listed "")
  if(EXISTS ${SOURCE_DIR}/src/fluovox/${module}/CMakeLists.txt)
    file(READ ${SOURCE_DIR}/src/fluovox/${module}/CMakeLists.txt listed)
  endif()
  file(GLOB_RECURSE sources RELATIVE ${SOURCE_DIR}
    ${SOURCE_DIR}/src/fluovox/${module}/*.h ${SOURCE_DIR}/src/fluovox/${module}/*.cpp)
  foreach(source IN LISTS sources)
    get_filename_component(name ${source} NAME)
    set(is_public FALSE)
    if(name MATCHES "\\.h$" AND listed MATCHES "[ \n]${name}")
      set(is_public TRUE)
    endif()
    file(STRINGS ${SOURCE_DIR}/${source} lines REGEX "^[ \t]*#[ \t]*include")
    foreach(line IN LISTS lines)
      set(why "")
      if(line MATCHES "\"fluovox/([a-z_]+)/" AND NOT CMAKE_MATCH_1 STREQUAL module
         AND NOT CMAKE_MATCH_1 IN_LIST may_include_${module})
        set(why "${module} must not include ${CMAKE_MATCH_1}")
      elseif(is_public AND line MATCHES "[<\"](${hidden_libraries})")
        set(why "a public header must not show that library")
      endif()
      if(why)
        # Only now is the line's number worth looking for.
        file(READ ${SOURCE_DIR}/${source} text)
        string(FIND "${text}" "${line}" position)
        string(SUBSTRING "${text}" 0 ${position} before)
        string(REGEX MATCHALL "\n" breaks "${before}")
        list(LENGTH breaks number)
        math(EXPR number "${number} + 1")
        list(APPEND offences "${source}:${number}: ${why}: ${line}")
      endif()
    endforeach()
  endforeach()
endforeach()

if(offences)
  list(JOIN offences "\n" offences)
  message("${offences}")
  message(FATAL_ERROR "the modules' order is broken")
endif()
