/// \file export.h
/// Marks what a shared build of the library exports.
#pragma once

#if defined(__GNUC__)
#define VOLCAUSTIC_API __attribute__((visibility("default")))
#else
#define VOLCAUSTIC_API
#endif
