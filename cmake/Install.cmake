# What `cmake --install` puts where. debian/*.install divides it among the packages.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/gprodom)

# The library, for C++ that runs the estimator itself: find_package(gprodom), gprodom::gprodom.
install(TARGETS gprodom EXPORT gprodom LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/gprodom DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT gprodom NAMESPACE gprodom:: FILE gprodom-targets.cmake DESTINATION ${package_folder})
install(FILES cmake/gprodom-config.cmake DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/gprodom-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/gprodom-config-version.cmake DESTINATION ${package_folder})
# The same in the build folder, for ros/ and for projects beside a checkout.
export(EXPORT gprodom NAMESPACE gprodom:: FILE ${PROJECT_BINARY_DIR}/gprodom-targets.cmake)
configure_file(cmake/gprodom-config.cmake ${PROJECT_BINARY_DIR}/gprodom-config.cmake COPYONLY)

# The programs, and what an operator reads and edits.
install(TARGETS gprodomd gprodom-replay RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES config/robot.yaml RENAME gprodom.yaml DESTINATION ${CMAKE_INSTALL_SYSCONFDIR}/gprodom)
install(DIRECTORY config/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/gprodom/config)
install(FILES config/gprodom.yaml config/cmu_gpr.yaml config/paper.yaml
  DESTINATION ${CMAKE_INSTALL_DATADIR}/gprodom/config)
install(DIRECTORY lcmtypes DESTINATION ${CMAKE_INSTALL_DATADIR}/gprodom FILES_MATCHING
  PATTERN *.lcm)
install(FILES share/man/gprodomd.8 DESTINATION ${CMAKE_INSTALL_MANDIR}/man8)
install(FILES share/man/gprodom-replay.1 share/man/gprodom.1
  DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
foreach(program gprodomd gprodom-replay gprodom)
  install(FILES share/completions/gprodom RENAME ${program}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
endforeach()

# The Python package. Where modules lie is the distribution's choice; none: it is not installed.
set(GPRODOM_PYTHON_INSTALL "" CACHE STRING "Folder for the Python package, such as lib/python3/dist-packages")
if(GPRODOM_PYTHON_INSTALL AND TARGET _core)
  install(DIRECTORY scripts/gprodom DESTINATION ${GPRODOM_PYTHON_INSTALL} FILES_MATCHING
    PATTERN *.py PATTERN *.pyi PATTERN py.typed PATTERN *.npz PATTERN split.json PATTERN __pycache__ EXCLUDE)
  install(DIRECTORY ${GPRODOM_PYTHON_OUTPUT}/gprodom/lcmtypes
    DESTINATION ${GPRODOM_PYTHON_INSTALL}/gprodom FILES_MATCHING PATTERN *.py)
  install(FILES ${GPRODOM_PYTHON_OUTPUT}/gprodom/_version.py
    DESTINATION ${GPRODOM_PYTHON_INSTALL}/gprodom)
  install(TARGETS _core LIBRARY DESTINATION ${GPRODOM_PYTHON_INSTALL}/gprodom)
  install(PROGRAMS share/gprodom DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
