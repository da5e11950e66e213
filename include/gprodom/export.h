// GPRODOM_EXPORT marks what libgprodom offers to other programs. Everything else in the library is
// hidden from them (cmake/Modules.cmake, cmake/libgprodom.map).
#pragma once

#define GPRODOM_EXPORT __attribute__((visibility("default")))
