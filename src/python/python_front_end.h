// A radar front end written in Python.
#pragma once

#include <pybind11/pybind11.h>

#include "gprodom/front_end.h"

// Calls `make`, a class or another callable without arguments, for each front end. Empty where
// `make` is None.
gprodom::gpr::FrontEndFactory python_front_end(const pybind11::object& make);
