# Module gprodom._core, where pybind11 can be had from the chosen Python.
set(venv_python ${PROJECT_SOURCE_DIR}/.venv/bin/python)
if(EXISTS ${venv_python})
  set(default_python ${venv_python})
else()
  set(default_python /usr/bin/python3)
endif()
set(GPRODOM_PYTHON ${default_python} CACHE FILEPATH "Python that the bindings are built for")

file(GLOB binding_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/python/*.cpp)
if(NOT binding_sources)
  return()
endif()
execute_process(COMMAND ${GPRODOM_PYTHON} -m pybind11 --cmakedir
  OUTPUT_VARIABLE pybind11_DIR OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET
  RESULT_VARIABLE pybind11_missing)
if(pybind11_missing)
  message(STATUS "No pybind11 for ${GPRODOM_PYTHON}: gprodom._core is not built (scripts/setup does)")
  return()
endif()

set(Python_EXECUTABLE ${GPRODOM_PYTHON})
set(PYBIND11_FINDPYTHON ON)
find_package(Python COMPONENTS Interpreter Development.Module REQUIRED)
find_package(pybind11 CONFIG REQUIRED)
pybind11_add_module(_core NO_EXTRAS ${binding_sources})
target_link_libraries(_core PRIVATE gprodom_settings ${modules})
# g++ 12 warns of the matrices that Debian's pybind11 2.10 makes and then fills, where several sources are
# compiled as one. PyPI's is newer.
target_compile_options(_core PRIVATE -Wno-maybe-uninitialized)
set_target_properties(_core PROPERTIES
  LIBRARY_OUTPUT_DIRECTORY ${GPRODOM_PYTHON_OUTPUT}/gprodom)
