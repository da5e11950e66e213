# What the project builds against; debian/control names the packages.
find_package(Eigen3 REQUIRED)
find_package(Threads REQUIRED)
find_package(glog REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(spdlog REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(LCM REQUIRED IMPORTED_TARGET lcm)
pkg_check_modules(GEOGRAPHIC REQUIRED IMPORTED_TARGET geographiclib)
pkg_check_modules(SYSTEMD REQUIRED IMPORTED_TARGET libsystemd)

# Debian's lcm-gen, also where a Python environment with another one is first on the path.
find_program(LCM_GEN lcm-gen PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)

# The Ceres::ceres target would link the static library and ATLAS with it.
find_library(CERES_SO NAMES libceres.so REQUIRED)
add_library(gprodom_ceres INTERFACE)
target_link_libraries(gprodom_ceres INTERFACE ${CERES_SO} glog::glog Eigen3::Eigen Threads::Threads)

# yaml-cpp 0.7 exports a plain target name.
add_library(gprodom_yaml INTERFACE)
target_link_libraries(gprodom_yaml INTERFACE ${YAML_CPP_LIBRARIES})
