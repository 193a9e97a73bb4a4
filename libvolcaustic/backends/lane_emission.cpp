// Emission in lanes: tile_emission.h over registers. Compiled once for each instruction set of lanes.h.

#include "backends/highway_lanes.h"
#include "backends/tile_emission.h"

namespace volcaustic {

namespace VOLCAUSTIC_INSTRUCTION_SET {

/// Sum of values, each turned into an integer with a factor before it is added.
class PowerSum {
public:
  VOLCAUSTIC_HD void add(Float v, double factor) {
    const hn::Half<FloatTag> half;
    add(hn::LowerHalf(half, v.v), factor);
    add(hn::UpperHalf(half, v.v), factor);
  }
  [[nodiscard]] VOLCAUSTIC_HD std::int64_t total() const { return hn::GetLane(hn::SumOfLanes(WholeTag(), mSum)); }

private:
  using DoubleTag = hn::ScalableTag<double>;
  using WholeTag = hn::ScalableTag<std::int64_t>;

  VOLCAUSTIC_HD void add(hn::Vec<hn::Half<FloatTag>> v, double factor) {
    const DoubleTag d;
    mSum = hn::Add(mSum, hn::ConvertTo(WholeTag(), hn::Mul(hn::PromoteTo(d, v), hn::Set(d, factor))));
  }

  hn::Vec<WholeTag> mSum = hn::Zero(WholeTag());
};

} // namespace VOLCAUSTIC_INSTRUCTION_SET

template <>
struct tiles::Packet<VOLCAUSTIC_INSTRUCTION_SET::Float> {
  using Float = VOLCAUSTIC_INSTRUCTION_SET::Float;
  static constexpr int kLanes = VOLCAUSTIC_INSTRUCTION_SET::kLanes;
  VOLCAUSTIC_HD static Float load(const float* p) { return VOLCAUSTIC_INSTRUCTION_SET::load(p); }
  VOLCAUSTIC_HD static void store(Float v, float* p) { VOLCAUSTIC_INSTRUCTION_SET::store(v, p); }
  VOLCAUSTIC_HD static int count(const VOLCAUSTIC_INSTRUCTION_SET::Mask& on) {
    return static_cast<int>(hwy::HWY_NAMESPACE::CountTrue(VOLCAUSTIC_INSTRUCTION_SET::FloatTag(), on.m));
  }
  using Sum = VOLCAUSTIC_INSTRUCTION_SET::PowerSum;
};

namespace VOLCAUSTIC_INSTRUCTION_SET {

void emitTileRow(const EmissionTask& task, std::int32_t tileRow, PhotonTally& tally) {
  tiles::TileRowEmission<Float>(task, tileRow, tally).run();
}
void findStops(const StopTask& task) { tiles::findStops<Float>(task); }

} // namespace VOLCAUSTIC_INSTRUCTION_SET
} // namespace volcaustic
