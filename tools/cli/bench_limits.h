// What this machine can do at most, measured beside the figures that are held against it.
#pragma once

#include <string>
#include <vector>

namespace volcaustic::cli {

struct MachineLimit {
  std::string key;  ///< in the JSON report, with its unit
  std::string text; ///< for people
  std::string unit;
  double oneThread = 0;
  double allThreads = 0; ///< rates: the sum over all threads at once; times: of each while all run
};

struct MachineLimits {
  std::string instructionSet; ///< "avx512", "avx2" or "baseline": what the arithmetic and the gathers use
  std::vector<MachineLimit> limits;
};

/// Copy bandwidth from memory and within the second-level cache, fused multiply-adds in 32-bit floats, and random
/// gathers of 16 floats from tables of 32 KiB, 1 MiB and 16 MiB. Takes a few seconds.
MachineLimits measureLimits(int threads);

} // namespace volcaustic::cli
