# What find_package(constrained_dynamics) reads.
include(CMakeFindDependencyMacro)
if(NOT TARGET Eigen3::Eigen)
  find_dependency(Eigen3 NO_MODULE)  # asked for 3.4, Eigen 5 would refuse
endif()
include(${CMAKE_CURRENT_LIST_DIR}/constrained_dynamics-targets.cmake)
