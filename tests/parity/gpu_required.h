// Tests that need a GPU skip by name where there is none.
#pragma once

#include "backends/cuda.h"

#include <gtest/gtest.h>

/// Skips the running test, or all tests of the fixture whose SetUp() it is in, with the reason.
#define VOLCAUSTIC_NEED_GPU()                                                                                          \
  do {                                                                                                                 \
    const volcaustic::CudaDevices cuda = volcaustic::findCudaDevices();                                                \
    if (cuda.devices.empty()) GTEST_SKIP() << "no CUDA device: " << cuda.whyNone;                                      \
    if (!cuda.devices[0].usable) GTEST_SKIP() << cuda.devices[0].id << ": " << cuda.devices[0].reason;                 \
  } while (false)
