#include "bench_table.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>

namespace volcaustic::cli {

namespace {

/// A line of the table. What the paper does not have stays empty.
struct Row {
  std::string text;
  std::function<std::string(const FrameFigures&)> here;
  std::function<std::string(const PaperFigures&)> paper = [](const PaperFigures&) { return ""; };
};

std::string ms(double milliseconds) { return fmt::format("{:.2f}", milliseconds); }
std::string thousands(double count) { return fmt::format("{:.0f}K", count / 1e3); }
std::string millions(double count) { return fmt::format("{:.2f}M", count / 1e6); }

Row stageRow(const char* text, const char* stage) {
  return {text, [stage](const FrameFigures& f) {
            const bool ran =
                std::any_of(f.stages.begin(), f.stages.end(), [&](const auto& run) { return run.first == stage; });
            return ran ? ms(f.milliseconds(stage)) : "";
          }};
}

std::vector<Row> sceneRows() {
  return {
      {"functional objects", [](const auto& f) { return std::to_string(f.objects); },
       [](const auto& p) { return std::to_string(p.objects); }},
      {"triangles", [](const auto& f) { return thousands(static_cast<double>(f.triangles)); },
       [](const auto& p) { return thousands(p.triangles); }},
      {"volume", [](const auto& f) { return fmt::format("{}³", f.size.resolution); },
       [](const auto&) { return "256³"; }},
      {"occupied voxels",
       [](const auto& f) { return fmt::format("{:.0f}³", std::cbrt(static_cast<double>(f.occupiedVoxels))); },
       [](const auto& p) { return fmt::format("{:.0f}³", p.occupiedCubeRoot); }},
      {"source photons", [](const auto& f) { return fmt::format("{}²", f.size.raster); },
       [](const auto&) { return "1024²"; }},
      {"photon steps", [](const auto& f) { return millions(static_cast<double>(f.balance.steps)); },
       [](const auto& p) { return millions(p.steps); }},
      {"photons that met the object",
       [](const auto& f) { return thousands(static_cast<double>(f.balance.photonsTraced)); },
       [](const auto& p) { return thousands(p.photonsTraced); }},
  };
}

std::vector<Row> timeRows() {
  const auto everythingElse = [](const FrameFigures& f) {
    return ms(f.milliseconds(kStepField) + f.milliseconds(kView) + f.milliseconds(kRest));
  };
  Row voxelisation = stageRow("voxelisation, ms", kVoxelisation);
  voxelisation.paper = [](const auto& p) { return ms(p.voxelisation); };
  Row photons = stageRow("photon tracing, ms", kPhotonTracing);
  photons.paper = [](const auto& p) { return ms(p.photonTracing); };
  return {voxelisation,
          photons,
          {"step field, view and the rest, ms", everythingElse, [](const auto& p) { return ms(p.everythingElse); }},
          stageRow("  step field (gradient, octree)", kStepField),
          stageRow("  view", kView),
          stageRow("  the rest", kRest),
          {"total, ms", [](const auto& f) { return ms(f.total()); }, [](const auto& p) { return ms(p.total); }},
          {"frames a second", [](const auto& f) { return fmt::format("{:.1f}", f.framesPerSecond()); },
           [](const auto& p) { return fmt::format("{:.0f}", p.framesPerSecond); }}};
}

/// The parts of photon tracing, in the order of the first scene.
std::vector<Row> partRows(std::span<const FrameFigures> frames) {
  std::vector<Row> rows;
  if (frames.empty()) return rows;
  for (const auto& [name, time] : frames.front().photonParts)
    rows.push_back({"  photon tracing: " + name, [name](const FrameFigures& f) {
                      for (const auto& [part, least] : f.photonParts)
                        if (part == name) return ms(least);
                      return std::string();
                    }});
  return rows;
}

std::vector<Row> derivedRows() {
  return {{"photon tracing, ns a photon step",
           [](const auto& f) { return fmt::format("{:.1f}", f.nanosecondsPerStep()); },
           [](const auto& p) { return fmt::format("{:.1f}", p.photonTracing * 1e6 / p.steps); }},
          {"voxels crossed", [](const auto& f) { return millions(static_cast<double>(f.balance.voxelsCrossed)); }},
          {"photon tracing, ns a voxel crossed",
           [](const auto& f) { return fmt::format("{:.1f}", f.nanosecondsPerVoxelCrossed()); }},
          {"peak memory, MiB",
           [](const auto& f) { return fmt::format("{:.0f}", static_cast<double>(f.peakMemoryBytes) / (1 << 20)); }}};
}

/// How many columns a terminal needs for UTF-8 text.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

std::string cell(const std::string& text) {
  constexpr std::size_t kWidth = 9;
  return std::string(kWidth - std::min(kWidth, width(text)), ' ') + text;
}

void printLine(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  fmt::print("{}\n", line);
}

void printRows(const std::vector<Row>& rows, std::span<const FrameFigures> frames) {
  for (const Row& row : rows) {
    std::string line = fmt::format("{:<36}", row.text);
    for (const FrameFigures& f : frames) {
      if (f.paper) line += cell(row.paper(*f.paper));
      line += cell(row.here(f)) + "  ";
    }
    printLine(std::move(line));
  }
}

} // namespace

void printFrames(const std::string& device, std::span<const FrameFigures> frames) {
  fmt::print("{}\n\n", device);
  std::string names(36, ' '), columns(36, ' ');
  for (const FrameFigures& f : frames) {
    const std::string name = cell(f.scene);
    names += f.paper ? cell("") + name + "  " : name + "  ";
    columns += (f.paper ? cell("paper") : "") + cell("here") + "  ";
  }
  printLine(std::move(names));
  printLine(std::move(columns));
  for (const auto& rows : {sceneRows(), timeRows(), partRows(frames), derivedRows()}) {
    printRows(rows, frames);
    fmt::print("\n");
  }
}

void printLimits(const MachineLimits& m, int threads) {
  fmt::print("{:<36}{:>11}{:>12}\n", fmt::format("this machine's limits ({})", m.instructionSet), "one thread",
             fmt::format("{} threads", threads));
  for (const MachineLimit& l : m.limits)
    fmt::print("{:<36}{:>11.1f}{:>12.1f}\n", fmt::format("{}, {}", l.text, l.unit), l.oneThread, l.allThreads);
}

} // namespace volcaustic::cli
