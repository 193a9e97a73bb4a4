// What a MixingSimulation holds.
#pragma once

#include "simulation/jet.h"
#include "simulation/pressure.h"
#include "volcaustic/simulation.h"

namespace volcaustic {

struct MixingSimulation::State {
  State(const MixingOptions& options, const Domain& domain, const RunContext& ctx);

  /// From `flow` for a whole frame.
  void advance(Flow& flow);

  MixingOptions options;
  RunContext ctx;
  Domain domain;
  Jet jet;
  PressureSolver solver;
  Flow flow;
  int frame = 0;

private:
  void step(Flow& flow, double begin, double time);
  [[nodiscard]] double longestStep(const Flow& flow) const;
};

} // namespace volcaustic
