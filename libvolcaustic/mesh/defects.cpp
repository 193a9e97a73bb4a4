// A MeshReport in words.
#include "volcaustic/mesh.h"

namespace volcaustic {

namespace {

/// "1 open edge", "223 open edges"
std::string counted(std::uint64_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

} // namespace

std::string describeDefects(const MeshReport& r) {
  std::string text;
  const auto add = [&](std::uint64_t count, const std::string& one, const std::string& many,
                       const std::string& detail = {}) {
    if (count > 0) text += (text.empty() ? "" : ", ") + counted(count, one, many) + detail;
  };
  add(r.openEdges, "open edge", "open edges");
  add(r.inconsistentEdges, "inconsistently wound edge", "inconsistently wound edges",
      r.flippedFaces > 0 ? " (" + counted(r.flippedFaces, "flipped face", "flipped faces") + ")" : "");
  add(r.unorientablePatches, "one-sided part", "one-sided parts");
  add(r.nonManifoldEdges, "non-manifold edge", "non-manifold edges");
  add(r.duplicateFaces, "duplicate face", "duplicate faces");
  add(r.degenerateFaces, "degenerate face", "degenerate faces");
  return text;
}

FillRoute fillRoute(const MeshReport& report) {
  if (report.closedAndConsistent()) return {true, "closed and consistently wound"};
  return {false, describeDefects(report)};
}

std::vector<std::string> shellRemarks(const MeshReport& r) {
  std::vector<std::string> remarks;
  if (r.immersedShells > 0)
    remarks.push_back(
        counted(r.immersedShells, "shell lies inside another and is wound like it",
                "shells lie inside others and are wound like them") +
        ": solid all through, because overlapping shells are a union; for a hollow body reverse the inner "
        "faces, for a liquid or an inclusion give them a material group of their own");
  if (r.cavities > 0)
    remarks.push_back(counted(r.cavities, "shell is a cavity", "shells are cavities") +
                      ": inside another and wound against it, so the body is hollow there");
  if (r.inwardBodies > 0)
    remarks.push_back(counted(r.inwardBodies, "shell faces inwards", "shells face inwards") +
                      ": filled all the same, because the fill counts windings of either sense");
  if (r.flatShells > 0)
    remarks.push_back(counted(r.flatShells, "closed shell is flat", "closed shells are flat") +
                      ": the faces come once for each side and enclose nothing; give the shape a thickness");
  if (!r.nestingComplete)
    remarks.push_back("more shells than can be compared in short time: nesting was looked at among the " +
                      std::to_string(MeshReport::kListedShells) + " of most area only");
  return remarks;
}

} // namespace volcaustic
