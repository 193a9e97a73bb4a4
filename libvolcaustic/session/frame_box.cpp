#include "volcaustic/error.h"
#include "volcaustic/session.h"

#include <algorithm>
#include <set>

namespace volcaustic {

Box boxOfFrames(Session& session, const SceneAtFrame& sceneAt, std::vector<int> frames) {
  const Scene& first = session.scene();
  const double margin = first.volume.margin;
  if (first.frames.last > first.frames.first) {
    frames.resize(static_cast<std::size_t>(first.frames.last - first.frames.first) + 1);
    for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = first.frames.first + static_cast<int>(i);
  }
  std::optional<Box> box;
  std::set<std::string> known;
  for (const int frame : frames) {
    session.context().throwIfCancelled();
    Scene at = sceneAt(frame);
    if (!known.insert(sceneHash(at)).second) continue;
    session.setScene(std::move(at));
    const std::optional<Box> content = session.contentBox();
    if (!content) continue; // nothing there yet
    if (!box) box = content;
    for (int a = 0; a < 3; ++a) {
      box->min[a] = std::min(box->min[a], content->min[a]);
      box->max[a] = std::max(box->max[a], content->max[a]);
    }
  }
  if (!box)
    throw Error(ErrorKind::Input,
                "volume.bounds: \"auto\" needs an object that is not empty in one of the frames; give min and max");
  return withMargin(*box, margin);
}

} // namespace volcaustic
