// Grids made from grids, value by value.
#pragma once

#include "core/parallel.h"

#include <openvdb/openvdb.h>

namespace volcaustic {

enum class Active {
  AsBefore,         ///< what was
  OtherThanNothing, ///< what was, and whatever is not the background: the inside of a level set
};

/// The grid of f(value) everywhere, background included, with the name and the transform of the source. `f` is called
/// from several threads.
template <class Result, class Source, class F>
typename Result::Ptr mappedGrid(const Source& source, Active active, const RunContext& ctx, const F& f) {
  using Tree = typename Result::TreeType;
  const auto background = f(source.background());
  auto tree = std::make_shared<Tree>(source.tree(), background, openvdb::TopologyCopy());

  auto from = source.tree().cbeginValueAll();
  auto to = tree->beginValueAll();
  from.setMaxDepth(decltype(from)::LEAF_DEPTH - 1);
  to.setMaxDepth(decltype(to)::LEAF_DEPTH - 1);
  for (; from; ++from, ++to) {
    const auto value = f(*from);
    to.setValue(value);
    to.setActiveState(from.isValueOn() || (active == Active::OtherThanNothing && value != background));
  }
  std::vector<const typename Source::TreeType::LeafNodeType*> sourceLeaves;
  std::vector<typename Tree::LeafNodeType*> leaves;
  source.tree().getNodes(sourceLeaves);
  tree->getNodes(leaves);
  parallelFor(static_cast<std::int64_t>(leaves.size()), 64, ctx, [&](std::int64_t begin, std::int64_t end, int) {
    for (std::int64_t i = begin; i < end; ++i)
      for (openvdb::Index v = 0; v < Tree::LeafNodeType::SIZE; ++v) {
        const auto value = f(sourceLeaves[i]->getValue(v));
        leaves[i]->setValueOnly(v, value);
        if (active == Active::OtherThanNothing && value != background) leaves[i]->setValueOn(v);
      }
  });
  auto result = Result::create(tree);
  result->setTransform(source.transform().copy());
  result->setName(source.getName());
  return result;
}

} // namespace volcaustic
