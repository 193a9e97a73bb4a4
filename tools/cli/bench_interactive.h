// bench --interactive: what one change of a scene costs, whole and rough, as a person makes it in a window.
#pragma once

#include "bench_scenes.h"
#include "report.h"

#include <volcaustic/run_context.h>

#include <string>
#include <utility>
#include <vector>

namespace volcaustic::cli {

/// One kind of change, made again and again.
struct ChangeFigures {
  std::string change;                                 ///< relight, material, deform or view
  double wholeMs = 0;                                 ///< median of a whole frame, from the change to the picture
  std::vector<std::pair<std::string, double>> stages; ///< median of each stage that ran, in order
  double movingMs = 0;                                ///< median time between pictures while changes follow each other
  int reduction = 1;                                  ///< of photons and pixels along each axis, at the end of that
};

struct InteractiveFigures {
  std::string scene;
  std::vector<ChangeFigures> changes;
};

/// Makes each change `repeats` times with all photons and pixels, and for `movingMs` milliseconds through a
/// LiveSession, which lowers their numbers.
InteractiveFigures measureInteractive(const BenchScene& scene, const BenchSize& size, int repeats, double movingMs,
                                      const RunContext& ctx);

Json interactiveReport(const InteractiveFigures& figures);
void printInteractive(const std::string& title, const std::vector<InteractiveFigures>& scenes);

} // namespace volcaustic::cli
