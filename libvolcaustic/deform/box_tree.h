// A tree of boxes around boxes, for finding those that touch another.
#pragma once

#include "volcaustic/types.h"

#include <cstdint>
#include <vector>

namespace volcaustic {

inline bool touch(const Box& a, const Box& b) {
  return a.min[0] <= b.max[0] && b.min[0] <= a.max[0] && a.min[1] <= b.max[1] && b.min[1] <= a.max[1] &&
         a.min[2] <= b.max[2] && b.min[2] <= a.max[2];
}

class BoxTree {
public:
  explicit BoxTree(const std::vector<Box>& boxes);

  /// Calls visit(index) for every box of a number above `after` that touches `box`, borders included.
  template <class Visit>
  void forTouching(const Box& box, std::uint32_t after, Visit&& visit) const {
    for (std::size_t n = 0; n < mNodes.size();) {
      const Node& node = mNodes[n];
      if (node.last <= after || !touch(node.box, box)) {
        n = node.next;
        continue;
      }
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        if (mItems[i].number > after && touch(mItems[i].box, box)) visit(mItems[i].number);
      ++n;
    }
  }

private:
  struct Item {
    Box box;
    std::uint32_t number;
  };
  /// In depth-first order.
  struct Node {
    Box box;
    std::uint32_t last = 0;           // greatest number in it
    std::uint32_t begin = 0, end = 0; // items, of a leaf
    std::size_t next = 0;             // node to go on with when this one is left out
  };

  void build(std::uint32_t begin, std::uint32_t end);

  std::vector<Item> mItems;
  std::vector<Node> mNodes;
};

} // namespace volcaustic
