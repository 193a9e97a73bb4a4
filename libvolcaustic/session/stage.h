// The latest results of one stage, by their keys.
#pragma once

#include "session/stage_key.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace volcaustic {

template <class Result>
class Stage {
public:
  /// The result of the key, which becomes the one asked for last; null where it is not there.
  std::shared_ptr<const Result> find(const StageKey& key) {
    const auto found = locate(key);
    if (found == mEntries.end()) return nullptr;
    std::rotate(mEntries.begin(), found, found + 1);
    return mEntries.front().result;
  }
  [[nodiscard]] bool has(const StageKey& key) const { return locate(key) != mEntries.end(); }
  /// In what the key differs from that of the result asked for last.
  [[nodiscard]] std::vector<std::string> because(const StageKey& key) const {
    return mLatest.empty() ? std::vector<std::string>{} : key.differences(mLatest.front());
  }
  /// Notes the key as the one asked for last, whether or not there is a result.
  void ask(const StageKey& key) { mLatest.assign(1, key); }
  /// Room for one more: drops results until fewer than `most` are left.
  void makeRoom(std::size_t most) {
    while (!mEntries.empty() && mEntries.size() >= most) mEntries.pop_back();
  }
  std::shared_ptr<const Result> keep(const StageKey& key, std::shared_ptr<const Result> result) {
    mEntries.insert(mEntries.begin(), {key.digest(), std::move(result)});
    return mEntries.front().result;
  }

private:
  struct Entry {
    std::uint64_t key;
    std::shared_ptr<const Result> result;
  };
  auto locate(const StageKey& key) {
    return std::find_if(mEntries.begin(), mEntries.end(), [&](const Entry& e) { return e.key == key.digest(); });
  }
  [[nodiscard]] auto locate(const StageKey& key) const {
    return std::find_if(mEntries.begin(), mEntries.end(), [&](const Entry& e) { return e.key == key.digest(); });
  }

  std::vector<Entry> mEntries;   // asked for last first
  std::vector<StageKey> mLatest; // one or none
};

} // namespace volcaustic
