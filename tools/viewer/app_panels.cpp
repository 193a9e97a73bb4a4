// What the window shows: the picture, what lies over it, and the panel beside it.
#include "app.h"

#include <volcaustic/device.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <imgui.h>
#include <numeric>

namespace volcaustic::viewer {

namespace {

constexpr float kPanelWidth = 390, kStatusHeight = 30;
constexpr const char* kVolumeLayers[] = {"radiance", "caustic",     "direct", "direction",
                                         "index",    "attenuation", "step",   "energy"};
constexpr ImGuiWindowFlags kFixed =
    ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoTitleBar;

ImVec2 screen(const Point& p) { return {static_cast<float>(p[0]), static_cast<float>(p[1])}; }

Vec3d mixed(const Vec3d& a, const Vec3d& b, double t) {
  return {a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t};
}

/// A picture on a quadrilateral in the world, in patches small enough for perspective.
void drawQuad(ImDrawList& draw, const Texture& texture, const std::array<Vec3d, 4>& corners,
              const Projection& projection) {
  constexpr int kPatches = 16;
  const auto at = [&](int i, int j) {
    const double u = double(i) / kPatches, v = double(j) / kPatches;
    return projection.toWindow(mixed(mixed(corners[0], corners[1], u), mixed(corners[3], corners[2], u), v));
  };
  for (int j = 0; j < kPatches; ++j)
    for (int i = 0; i < kPatches; ++i) {
      const auto a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      if (!a || !b || !c || !d) continue;
      const auto uv = [](int x, int y) { return ImVec2(float(x) / kPatches, float(y) / kPatches); };
      draw.AddImageQuad(texture.id(), screen(*a), screen(*b), screen(*c), screen(*d), uv(i, j), uv(i + 1, j),
                        uv(i + 1, j + 1), uv(i, j + 1));
    }
}

/// Triangles from back to front, shaded by where they face.
void drawSurface(ImDrawList& draw, const Mesh& mesh, const Projection& projection) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    order.emplace_back(-projection.depthOf(mesh.positions[mesh.triangles[t][0]]), t);
  std::sort(order.begin(), order.end());
  const ImDrawListFlags flags = draw.Flags; // no fringes between triangles
  draw.Flags &= ~ImDrawListFlags_AntiAliasedFill;
  for (const auto& [depth, t] : order) {
    const auto& [i, j, k] = mesh.triangles[t];
    const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
    const auto p = projection.toWindow(a), q = projection.toWindow(b), r = projection.toWindow(c);
    if (!p || !q || !r) continue;
    const double facing = ((*q)[0] - (*p)[0]) * ((*r)[1] - (*p)[1]) - ((*q)[1] - (*p)[1]) * ((*r)[0] - (*p)[0]);
    if (facing >= 0) continue; // away from the eye
    Vec3d n{};
    for (int x = 0; x < 3; ++x) {
      const int y = (x + 1) % 3, z = (x + 2) % 3;
      n[x] = (b[y] - a[y]) * (c[z] - a[z]) - (b[z] - a[z]) * (c[y] - a[y]);
    }
    const double light =
        .55 + .45 * (.3 * n[0] - .5 * n[1] + .8 * n[2]) / std::max(std::hypot(n[0], n[1], n[2]), 1e-30);
    const int grey = static_cast<int>(std::clamp(light, .1, 1.0) * 220);
    draw.AddTriangleFilled(screen(*p), screen(*q), screen(*r), IM_COL32(grey, grey * 92 / 100, grey * 75 / 100, 235));
  }
  draw.Flags = flags;
}

} // namespace

void App::drawFrame() {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float panel = std::min(kPanelWidth, size.x * .5f);
  drawPicture({0, 0, std::max(size.x - panel, 1.f), std::max(size.y - kStatusHeight, 1.f)});
  drawPanel(size.x - panel, panel, size.y - kStatusHeight);
  drawStatus(size.y - kStatusHeight, size.x, kStatusHeight);
  handleMouse();
  handleKeys();
}

void App::drawPicture(const PictureArea& room) {
  const Camera& camera = mHistory.current().camera;
  mRoom = room;
  mArea = fitted(room, camera.resolution);
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  if (mShown && mShown->view)
    draw.AddImage(mPicture.id(), screen({mArea.x, mArea.y}), screen({mArea.x + mArea.width, mArea.y + mArea.height}));
  const Projection projection(camera, mArea);
  if (mIsovalue >= 0 && !mIso.empty()) drawSurface(draw, mIso, projection);
  if (mSliceShown && mSlicePicture.width() > 0) drawQuad(draw, mSlicePicture, mSliceValues.corners, projection);
  drawOverlay();
}

void App::drawPanel(float x, float width, float height) {
  ImGui::SetNextWindowPos({x, 0});
  ImGui::SetNextWindowSize({width, height});
  ImGui::Begin("panel", nullptr, kFixed);
  drawToolbar();
  if (ImGui::BeginTabBar("tabs")) {
    if (ImGui::BeginTabItem("scene")) {
      ImGui::BeginChild("options");
      Scene scene = mHistory.current();
      const Edited edited = sceneWidgets(scene);
      if (edited.changed) {
        setScene(std::move(scene), !mEdited);
        mEdited = true;
      }
      if (edited.finished) mEdited = false;
      ImGui::EndChild();
      ImGui::EndTabItem();
    }
    if (ImGui::BeginTabItem("layers")) {
      drawLayers();
      drawHistogram();
      ImGui::EndTabItem();
    }
    if (ImGui::BeginTabItem("stages")) {
      drawStages();
      ImGui::EndTabItem();
    }
    ImGui::EndTabBar();
  }
  ImGui::End();
}

void App::drawToolbar() {
  const std::filesystem::path stem = mOptions.scene.stem();
  const auto button = [](const char* label, bool enabled = true) {
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::Button(label);
    ImGui::EndDisabled();
    ImGui::SameLine();
    return pressed;
  };
  if (button("undo", mHistory.canUndo())) undo();
  if (button("redo", mHistory.canRedo())) redo();
  try {
    if (button("shot")) {
      saveScreenshot(stem.string() + ".shot.png");
      say("wrote " + stem.string() + ".shot.png");
    }
    if (button("save")) saveScene(stem.string() + ".edited.json");
    if (button(".vdb")) exportTo(stem.string() + ".vdb");
    if (button(".exr")) exportTo(stem.string() + ".exr");
  } catch (const std::exception& error) {
    say(error.what());
  }
  ImGui::SetNextItemWidth(-1);
  if (ImGui::BeginCombo("##device", mDevice.c_str())) {
    std::vector<std::string> words{"auto", "cpu", "hybrid"};
    for (const DeviceInfo& device : listDevices())
      if (device.usable && device.id != "cpu") words.push_back(device.id);
    for (const std::string& word : words)
      if (ImGui::Selectable(word.c_str(), word == mDevice)) mRevision = mLive->setDevice(mDevice = word);
    ImGui::EndCombo();
  }
  const SceneFrames& frames = mHistory.current().frames;
  if (frames.last == frames.first) return;
  if (button(mPlaying ? "stop" : "play")) mPlaying = !mPlaying;
  int frame = mFrame;
  ImGui::SetNextItemWidth(-1);
  if (ImGui::SliderInt("##frame", &frame, frames.first, frames.last, "frame %d")) goToFrame(frame);
}

void App::drawLayers() {
  if (mShown && mShown->view && ImGui::BeginCombo("picture", mLayer.c_str())) {
    for (const std::string& layer : layersOf(mShown->view->image))
      if (ImGui::Selectable(layer.c_str(), layer == mLayer)) {
        mLayer = layer;
        uploadPicture();
      }
    ImGui::EndCombo();
  }
  float exposure = static_cast<float>(mHistory.current().view.exposure);
  if (ImGui::SliderFloat("exposure", &exposure, -10, 10, "%.1f stops")) {
    Scene next = mHistory.current();
    next.view.exposure = exposure;
    setScene(std::move(next), !mEdited);
    mEdited = true;
    uploadPicture();
  }
  if (ImGui::IsItemDeactivatedAfterEdit()) mEdited = false;
  ImGui::Checkbox("overlay (O)", &mOverlayShown);
  ImGui::Separator();
  bool changed = ImGui::Checkbox("slice (S)", &mSliceShown);
  int layer = static_cast<int>(mSlice.layer);
  changed |= ImGui::Combo("volume", &layer, kVolumeLayers, static_cast<int>(std::size(kVolumeLayers)));
  mSlice.layer = static_cast<VolumeLayer>(layer);
  changed |= ImGui::Combo("across", &mSlice.axis, "x\0y\0z\0");
  float position = static_cast<float>(mSlice.position), stops = static_cast<float>(mSliceLook.exposure);
  changed |= ImGui::SliderFloat("position", &position, 0, 1);
  changed |= ImGui::SliderFloat("light", &stops, -10, 10, "%.1f stops");
  if (mSliceShown && isLight(mSlice.layer))
    ImGui::TextDisabled("white is %.3g %s", whiteOf(mSliceValues) * std::exp2(-mSliceLook.exposure),
                        mSlice.layer == VolumeLayer::Energy ? "W/m3" : "W/(m2 sr)");
  mSlice.position = position;
  mSliceLook.exposure = stops;
  changed |= ImGui::Checkbox("colours", &mSliceLook.colours);
  if (changed) mSliceShown ? uploadSlice() : uploadPicture();
  ImGui::Separator();
  bool iso = mIsovalue >= 0;
  float value = iso ? static_cast<float>(mIsovalue) : .5f;
  const bool toggled = ImGui::Checkbox("iso-surface of coverage", &iso);
  const bool moved = iso && ImGui::SliderFloat("coverage", &value, .02f, .98f);
  if (toggled || moved) {
    mIsovalue = iso ? value : -1;
    mShown.reset(); // taken again, with its surface
  }
}

void App::drawHistogram() {
  ImGui::Separator();
  if (mHistogram.counts.empty()) return;
  std::vector<float> heights;
  for (const float n : mHistogram.counts) heights.push_back(std::log1p(n));
  ImGui::PlotHistogram("##histogram", heights.data(), static_cast<int>(heights.size()), 0, nullptr, 0, FLT_MAX,
                       {ImGui::GetContentRegionAvail().x, 110});
  ImGui::Text("%.4g to %.4g%s", mHistogram.least, mHistogram.greatest, mHistogram.logarithmic ? ", by decades" : "");
}

void App::drawStages() {
  if (!mShown) return;
  ImGui::Text("%.1f ms, photons and pixels / %d", mShown->milliseconds, mShown->reduction);
  if (ImGui::BeginTable("runs", 2, ImGuiTableFlags_RowBg)) {
    for (const StageRun& run : mShown->runs) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(run.stage.c_str());
      ImGui::TableNextColumn();
      ImGui::Text("%.1f ms", run.milliseconds);
      for (const std::string& place : run.because) ImGui::TextDisabled("%s", place.c_str());
    }
    ImGui::EndTable();
  }
  if (!mShown->photons) return;
  ImGui::Separator();
  for (const PassPart& part : mShown->photons->parts) ImGui::TextDisabled("%-18s %8.1f ms", part.name.c_str(), part.ms);
  const EnergyBalance& b = mShown->photons->balance;
  ImGui::Separator();
  ImGui::Text("emitted   %10.4g W", b.emitted[1]);
  ImGui::Text("absorbed  %10.4g W", b.absorbed[1]);
  ImGui::Text("scattered %10.4g W", b.scattered[1]);
  ImGui::Text("landed    %10.4g W", b.received[1]);
  ImGui::Text("photons   %10lld", static_cast<long long>(b.photonsTraced));
}

void App::drawStatus(float y, float width, float height) {
  ImGui::SetNextWindowPos({0, y});
  ImGui::SetNextWindowSize({width, height});
  ImGui::Begin("status", nullptr, kFixed | ImGuiWindowFlags_NoScrollbar);
  const auto [stage, part] = mLive->progress();
  if (mShown)
    ImGui::Text("%3zu pictures/s  %6.1f ms  1/%d  frame %d  %s", mPictureTimes.size(), mShown->milliseconds,
                mShown->reduction, mFrame,
                mLive->busy()           ? stage.c_str()
                : mShown->error.empty() ? "whole"
                                        : "failed");
  else
    ImGui::Text("the first picture: %s %.0f %%", stage.c_str(), 100 * part);
  if (Clock::now() - mMessageTime < std::chrono::seconds(8) && !mMessage.empty()) {
    ImGui::SameLine(width * .45f);
    ImGui::TextUnformatted(mMessage.c_str());
  }
  ImGui::End();
}

} // namespace volcaustic::viewer
