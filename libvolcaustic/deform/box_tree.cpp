#include "deform/box_tree.h"

#include <algorithm>

namespace volcaustic {

namespace {

constexpr std::uint32_t kLeafSize = 4;

double centre(const Box& box, std::size_t axis) { return box.min[axis] / 2 + box.max[axis] / 2; }

} // namespace

BoxTree::BoxTree(const std::vector<Box>& boxes) {
  mItems.reserve(boxes.size());
  for (std::uint32_t i = 0; i < boxes.size(); ++i) mItems.push_back({boxes[i], i});
  if (!boxes.empty()) build(0, static_cast<std::uint32_t>(boxes.size()));
}

void BoxTree::build(std::uint32_t begin, std::uint32_t end) {
  const std::size_t at = mNodes.size();
  Node node{mItems[begin].box, mItems[begin].number};
  Vec3d low, high; // of the boxes' centres
  for (std::size_t k = 0; k < 3; ++k) low[k] = high[k] = centre(node.box, k);
  for (std::uint32_t i = begin + 1; i < end; ++i) {
    node.last = std::max(node.last, mItems[i].number);
    for (std::size_t k = 0; k < 3; ++k) {
      node.box.min[k] = std::min(node.box.min[k], mItems[i].box.min[k]);
      node.box.max[k] = std::max(node.box.max[k], mItems[i].box.max[k]);
      low[k] = std::min(low[k], centre(mItems[i].box, k));
      high[k] = std::max(high[k], centre(mItems[i].box, k));
    }
  }
  const bool leaf = end - begin <= kLeafSize;
  if (leaf) node.begin = begin, node.end = end;
  mNodes.push_back(node);
  if (!leaf) {
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(mItems.begin() + begin, mItems.begin() + middle, mItems.begin() + end,
                     [axis](const Item& a, const Item& b) {
                       const double x = centre(a.box, axis), y = centre(b.box, axis);
                       return x != y ? x < y : a.number < b.number;
                     });
    build(begin, middle);
    build(middle, end);
  }
  mNodes[at].next = mNodes.size();
}

} // namespace volcaustic
