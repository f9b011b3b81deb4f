# The one list of what fluovox links; the installed package includes this same file.
include(CMakeFindDependencyMacro)
list(PREPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})

find_dependency(TBB CONFIG REQUIRED)
find_dependency(OpenVDB 10.0 REQUIRED)
find_dependency(OpenEXR CONFIG REQUIRED)
find_dependency(PNG REQUIRED)
find_dependency(assimp CONFIG REQUIRED)
find_dependency(fmt CONFIG REQUIRED)
find_dependency(tomlplusplus CONFIG REQUIRED)
find_dependency(nlohmann_json CONFIG REQUIRED)
find_dependency(PkgConfig)
pkg_check_modules(Cairo REQUIRED QUIET IMPORTED_TARGET cairo)
