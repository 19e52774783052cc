# Targets of the installed deployment engine: vci::vci and vci::files.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4)
find_dependency(nlohmann_json)
find_dependency(fcl)
find_dependency(VTK 9.1 COMPONENTS CommonCore CommonDataModel IOXML IOGeometry FiltersCore FiltersGeneral)
include(${CMAKE_CURRENT_LIST_DIR}/vciTargets.cmake)
