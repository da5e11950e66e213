// Enums of gprodom/choices.h as Python has them: by their names.
#pragma once

#include <pybind11/pybind11.h>

#include <stdexcept>
#include <string>

#include "gprodom/choices.h"

// Throws std::invalid_argument, which names the choices.
template <class Choice>
Choice choice_argument(const std::string& argument, const std::string& name) {
  if (const auto choice = gprodom::find_choice<Choice>(name)) return *choice;
  throw std::invalid_argument(argument + ": expected one of " + gprodom::all_names<Choice>() +
                              ", got \"" + name + "\"");
}

// A readable and writable property of that name.
template <class Class, class Choice>
void def_choice(pybind11::class_<Class>& bound, const char* property, Choice Class::*member) {
  bound.def_property(
      property, [member](const Class& object) { return gprodom::name_of(object.*member); },
      [member, property](Class& object, const std::string& name) {
        object.*member = choice_argument<Choice>(property, name);
      });
}
