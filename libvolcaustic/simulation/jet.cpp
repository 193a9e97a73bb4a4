#include "simulation/jet.h"

#include "volcaustic/error.h"

#include <cmath>
#include <numbers>
#include <random>

namespace volcaustic {

namespace {

/// Part of the square of edge `cell` around (x, y) within `radius` of the origin, by the middles of its parts.
double covered(double x, double y, double cell, double radius) {
  if (std::hypot(x, y) > radius + cell) return 0;
  if (std::hypot(x, y) < radius - cell) return 1;
  constexpr int kParts = 32;
  int inside = 0;
  for (int j = 0; j < kParts; ++j)
    for (int i = 0; i < kParts; ++i)
      inside += std::hypot(x + cell * ((i + .5) / kParts - .5), y + cell * ((j + .5) / kParts - .5)) < radius;
  return static_cast<double>(inside) / (kParts * kParts);
}

/// Zero through the sides and the bottom.
void closeWalls(StaggeredVelocity& velocity, const Vec3i& cells) {
  for (int a = 0; a < 3; ++a) {
    Lattice& faces = velocity.component[a];
    Vec3i count = faces.dims();
    count[a] = 1;
    const std::size_t far = a == 2 ? 0 : cells[a] * faces.stride(a);
    for (int k = 0; k < count[2]; ++k)
      for (int j = 0; j < count[1]; ++j)
        for (int i = 0; i < count[0]; ++i) {
          const std::size_t near = faces.index(i, j, k);
          faces.values()[near] = faces.values()[near + far] = 0;
        }
  }
}

} // namespace

Jet::Jet(const MixingOptions& options, const Vec3i& cells, double cell, std::uint64_t seed)
    : mSpeed(options.inflow), mDisturbance(options.disturbance) {
  if (options.inflow <= 0 || options.inflowRadius <= 0) return;
  for (int j = 0; j < cells[1]; ++j)
    for (int i = 0; i < cells[0]; ++i) {
      const double x = (i + .5 - .5 * cells[0]) * cell, y = (j + .5 - .5 * cells[1]) * cell;
      if (const double open = covered(x, y, cell, options.inflowRadius); open > 0) mFaces.push_back({i, j, open, x, y});
    }
  if (mFaces.empty())
    throw Error(ErrorKind::Usage, "mixing: the hole is smaller than a cell; raise resolution or inflowRadius");
  // Parts of faces are sampled; a hole that lies in the bottom as a whole lets in what a round one does.
  double sum = 0;
  for (const Face& face : mFaces) sum += face.open * cell * cell;
  if (2 * options.inflowRadius <= cell * std::min(cells[0], cells[1]))
    for (Face& face : mFaces) face.open *= std::numbers::pi * options.inflowRadius * options.inflowRadius / sum;
  std::mt19937_64 random(seed);
  // The standard's distributions differ from library to library; its engines do not.
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (Wave& wave : mWaves) {
    const double angle = 2 * std::numbers::pi * uniform();
    const double number = std::numbers::pi / options.inflowRadius * (.5 + 1.5 * uniform());
    const double frequency = options.inflow / options.inflowRadius * (.5 + 2 * uniform());
    wave = {number * std::cos(angle), number * std::sin(angle), frequency, 2 * std::numbers::pi * uniform()};
  }
}

double Jet::speed(const Face& face, double time) const {
  double sum = 0;
  for (const Wave& wave : mWaves)
    sum += std::cos(wave.x * face.x + wave.y * face.y + wave.frequency * time + wave.phase);
  const double waver = std::clamp(sum / std::sqrt(static_cast<double>(mWaves.size())), -1., 1.);
  return mSpeed * face.open * (1 + mDisturbance * waver);
}

void Jet::impose(Flow& flow, double time) const {
  closeWalls(flow.velocity, flow.cells);
  Lattice& upwards = flow.velocity.component[2];
  Lattice& c = flow.concentration;
  const int top = flow.cells[2];
  for (int j = 0; j < flow.cells[1]; ++j)
    for (int i = 0; i < flow.cells[0]; ++i) {
      c.at(i, j, 0) = c.at(i, j, 1);
      c.at(i, j, top + 1) = upwards.at(i, j, top) < 0 ? 0 : c.at(i, j, top);
    }
  for (const Face& face : mFaces) {
    c.at(face.i, face.j, 0) = 1;
    upwards.at(face.i, face.j, 0) = static_cast<float>(speed(face, time));
  }
}

} // namespace volcaustic
