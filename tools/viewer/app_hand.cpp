// Mouse and keyboard: what they take hold of, and what follows them.
#include "app.h"

#include <algorithm>
#include <cmath>
#include <GLFW/glfw3.h>
#include <imgui.h>
#include <utility>

namespace volcaustic::viewer {

namespace {

constexpr double kReach = 12; // pixels around a light or a handle

Point mousePoint() { return {ImGui::GetIO().MousePos.x, ImGui::GetIO().MousePos.y}; }
double distance(const Point& a, const Point& b) { return std::hypot(a[0] - b[0], a[1] - b[1]); }
Point difference(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1]}; }

Vec3d placed(const Affine& m, const Vec3d& p) {
  Vec3d q{};
  for (int k = 0; k < 3; ++k) q[k] = m[k][0] * p[0] + m[k][1] * p[1] + m[k][2] * p[2] + m[k][3];
  return q;
}

/// The shift in an object's own space that is `shift` in the world: Cramer's rule on the linear part.
Vec3d inOwnSpace(const Affine& m, const Vec3d& shift) {
  const auto determinant = [](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) + c[0] * (a[1] * b[2] - a[2] * b[1]);
  };
  Vec3d columns[3];
  for (int j = 0; j < 3; ++j) columns[j] = {m[0][j], m[1][j], m[2][j]};
  const double whole = determinant(columns[0], columns[1], columns[2]);
  return {determinant(shift, columns[1], columns[2]) / whole, determinant(columns[0], shift, columns[2]) / whole,
          determinant(columns[0], columns[1], shift) / whole};
}

/// A directional light's arrow ends at the target and begins against its direction.
Vec3d arrowStart(const Scene& scene, const Light& light) {
  if (light.type != LightType::Directional) return light.position;
  const Vec3d& d = light.direction;
  double away = 0, size = std::hypot(d[0], d[1], d[2]);
  for (int a = 0; a < 3; ++a) away += std::pow(scene.camera.position[a] - scene.camera.target[a], 2);
  const double part = .25 * std::sqrt(away) / std::max(size, 1e-12);
  return {scene.camera.target[0] - part * d[0], scene.camera.target[1] - part * d[1],
          scene.camera.target[2] - part * d[2]};
}

std::string keyOf(const Scene& scene, std::size_t object) {
  Scene alone;
  alone.objects = {scene.objects[object]};
  std::string key = sceneToJson(alone);
  if (scene.objects[object].mesh)
    key += std::to_string(reinterpret_cast<std::uintptr_t>(scene.objects[object].mesh.get()));
  return key;
}

} // namespace

/// The triangles of an object, made anew when it has changed. Null for a volume, or where it cannot be made.
const Mesh* App::surfaceOf(std::size_t object) {
  const Scene& scene = mHistory.current();
  if (!scene.objects[object].visible || !scene.objects[object].volumeFile.empty()) return nullptr;
  mPickable.resize(scene.objects.size());
  auto& [key, mesh] = mPickable[object];
  const std::string now = keyOf(scene, object);
  if (key == now) return mesh.get();
  key = now;
  mesh = nullptr;
  try {
    mSurfaces.setScene(scene);
    mesh = mSurfaces.surface(object);
  } catch (const std::exception& error) {
    say(error.what());
  }
  return mesh.get();
}

std::optional<Vec3d> App::placeOf(const Grip& grip) const {
  const Scene& scene = mHistory.current();
  switch (grip.kind) {
  case Grip::Kind::None:
    return std::nullopt;
  case Grip::Kind::Light:
    if (grip.object >= scene.lights.size() || scene.lights[grip.object].type == LightType::Environment)
      return std::nullopt;
    return arrowStart(scene, scene.lights[grip.object]);
  case Grip::Kind::Object:
    if (grip.object >= scene.objects.size()) return std::nullopt;
    return scene.objects[grip.object].placement.translate;
  case Grip::Kind::Handle: {
    if (grip.object >= scene.objects.size() || grip.handle >= scene.objects[grip.object].deform.size())
      return std::nullopt;
    const Deformer& d = scene.objects[grip.object].deform[grip.handle];
    Vec3d p = d.center;
    if (d.type == DeformerType::Handle)
      for (int a = 0; a < 3; ++a) p[a] += d.placement.translate[a];
    return placed(affine(scene.objects[grip.object].placement), p);
  }
  }
  return std::nullopt;
}

Grip App::gripAt(const Point& p) {
  const Scene& scene = mHistory.current();
  const Projection projection(scene.camera, mArea);
  const auto near = [&](const Grip& grip) {
    const auto place = placeOf(grip);
    const auto at = place ? projection.toWindow(*place) : std::nullopt;
    return at && distance(*at, p) < kReach;
  };
  if (mOverlayShown) {
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
      if (const Grip grip{Grip::Kind::Light, i}; near(grip)) return grip;
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
      for (std::size_t h = 0; h < scene.objects[i].deform.size(); ++h)
        if (const Grip grip{Grip::Kind::Handle, i, h}; near(grip)) return grip;
  }
  Grip nearest;
  double at = 0;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Mesh* mesh = surfaceOf(i);
    const auto there = mesh ? hit(*mesh, scene.camera.position, projection.rayThrough(p)) : std::nullopt;
    if (!there || (nearest.kind != Grip::Kind::None && *there >= at)) continue;
    nearest = {Grip::Kind::Object, i};
    at = *there;
  }
  return nearest;
}

void App::move(Scene& scene, const Grip& grip, const Vec3d& shift) {
  const auto add = [](Vec3d& to, const Vec3d& what) {
    for (int a = 0; a < 3; ++a) to[a] += what[a];
  };
  switch (grip.kind) {
  case Grip::Kind::None:
    break;
  case Grip::Kind::Object:
    add(scene.objects[grip.object].placement.translate, shift);
    break;
  case Grip::Kind::Handle: {
    SceneObject& object = scene.objects[grip.object];
    Deformer& d = object.deform[grip.handle];
    const Vec3d own = inOwnSpace(affine(object.placement), shift);
    add(d.type == DeformerType::Handle ? d.placement.translate : d.center, own);
    break;
  }
  case Grip::Kind::Light: {
    Light& light = scene.lights[grip.object];
    if (light.type != LightType::Directional) {
      add(light.position, shift);
      break;
    }
    // Its arrow keeps pointing at the target.
    Vec3d start = arrowStart(scene, light);
    add(start, shift);
    for (int a = 0; a < 3; ++a) light.direction[a] = scene.camera.target[a] - start[a];
    break;
  }
  }
}

void App::handleMouse() {
  const ImGuiIO& io = ImGui::GetIO();
  const Point mouse = mousePoint();
  const bool over = mRoom.contains(mouse) && !io.WantCaptureMouse;
  if (over && io.MouseWheel != 0) {
    Scene next = mHistory.current();
    next.camera = zoomed(next.camera, io.MouseWheel);
    setScene(std::move(next), false);
  }
  if (over && !mDragStart && (ImGui::IsMouseClicked(0) || ImGui::IsMouseClicked(1) || ImGui::IsMouseClicked(2))) {
    mDragStart = mHistory.current();
    mDragFrom = mDragLast = mouse;
    mDragged = {};
    if (ImGui::IsMouseClicked(0)) mDragged = mSelected = gripAt(mouse);
    mPanning = ImGui::IsMouseClicked(1);
    mOrbiting = !mPanning && mDragged.kind == Grip::Kind::None;
    if (const auto place = placeOf(mDragged))
      mDragDepth = std::max(Projection(mHistory.current().camera, mArea).depthOf(*place), 1e-6);
  }
  if (!mDragStart) return;
  const Point movement = difference(mouse, mDragFrom);
  if (std::exchange(mDragLast, mouse) != mouse) {
    Scene next = *mDragStart;
    if (mPanning)
      next.camera = panned(next.camera, movement, mArea);
    else if (mOrbiting)
      next.camera = orbited(next.camera, movement, mArea.height);
    else
      move(next, mDragged, Projection(next.camera, mArea).inWorld(movement, mDragDepth));
    setScene(std::move(next), !mEdited); // the first movement of a drag is the step to undo
    mEdited = true;
  }
  if (!io.MouseDown[0] && !io.MouseDown[1] && !io.MouseDown[2]) {
    endDrag();
  }
}

void App::handleKeys() {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) return;
  for (const KeyPress& press : mWindow.keys()) {
    if (press.control && press.key == GLFW_KEY_Z) undo();
    if (press.control && press.key == GLFW_KEY_Y) redo();
    if (press.control && press.key == GLFW_KEY_Q) mWindow.close();
    if (press.control) continue;
    const SceneFrames& frames = mHistory.current().frames;
    if (press.key == GLFW_KEY_O) mOverlayShown = !mOverlayShown;
    if (press.key == GLFW_KEY_SPACE) mPlaying = !mPlaying && frames.last > frames.first;
    if (press.key == GLFW_KEY_S) {
      mSliceShown = !mSliceShown;
      mSliceShown ? uploadSlice() : uploadPicture();
    }
  }
}

/// Of the selected object. While it is dragged its triangles are those of the start, shifted.
std::optional<Box> App::selectedBox() {
  const std::size_t i = mSelected.object;
  const std::vector<SceneObject>& objects = mHistory.current().objects;
  if (mSelected.kind != Grip::Kind::Object || i >= objects.size()) return std::nullopt;
  const bool dragged = mDragStart && mDragged == mSelected && i < mPickable.size();
  const Mesh* mesh = dragged ? mPickable[i].second.get() : surfaceOf(i);
  if (!mesh) return std::nullopt;
  Box box = bounds(*mesh);
  for (int a = 0; dragged && a < 3; ++a) {
    const double shift = objects[i].placement.translate[a] - mDragStart->objects[i].placement.translate[a];
    box.min[a] += shift;
    box.max[a] += shift;
  }
  return box;
}

void App::drawOverlay() {
  if (!mOverlayShown) return;
  const Scene& scene = mHistory.current();
  const Projection projection(scene.camera, mArea);
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const auto toScreen = [&](const Vec3d& p) -> std::optional<ImVec2> {
    const auto at = projection.toWindow(p);
    return at ? std::optional(ImVec2(static_cast<float>((*at)[0]), static_cast<float>((*at)[1]))) : std::nullopt;
  };
  const auto line = [&](const Vec3d& a, const Vec3d& b, ImU32 colour) {
    const auto p = toScreen(a), q = toScreen(b);
    if (p && q) draw.AddLine(*p, *q, colour, 1.2f);
  };
  const auto box = [&](const Vec3d& low, const Vec3d& high, ImU32 colour) {
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < 4; ++i) {
        Vec3d p = low;
        p[(a + 1) % 3] = i & 1 ? high[(a + 1) % 3] : low[(a + 1) % 3];
        p[(a + 2) % 3] = i & 2 ? high[(a + 2) % 3] : low[(a + 2) % 3];
        Vec3d q = p;
        q[a] = high[a];
        line(p, q, colour);
      }
  };
  draw.PushClipRect({static_cast<float>(mArea.x), static_cast<float>(mArea.y)},
                    {static_cast<float>(mArea.x + mArea.width), static_cast<float>(mArea.y + mArea.height)});
  if (mShown && mShown->medium) {
    const Domain& domain = mShown->medium->domain();
    box(domain.minCorner, domain.maxCorner(), IM_COL32(255, 255, 255, 40));
  }
  if (const auto around = selectedBox()) box(around->min, around->max, IM_COL32(255, 190, 80, 200));
  const auto grip = [&](const Grip& g, ImU32 colour) {
    const auto place = placeOf(g);
    const auto at = place ? toScreen(*place) : std::nullopt;
    if (!at) return;
    draw.AddCircleFilled(*at, 5, colour);
    if (g == mSelected) draw.AddCircle(*at, 9, IM_COL32(255, 190, 80, 255), 0, 2);
  };
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const Light& light = scene.lights[i];
    if (light.type == LightType::Environment) continue;
    const Vec3d start = arrowStart(scene, light);
    if (light.type == LightType::Directional) line(start, scene.camera.target, IM_COL32(255, 230, 120, 110));
    grip({Grip::Kind::Light, i}, IM_COL32(255, 230, 120, 255));
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    for (std::size_t h = 0; h < scene.objects[i].deform.size(); ++h)
      grip({Grip::Kind::Handle, i, h}, IM_COL32(120, 200, 255, 255));
  draw.PopClipRect();
}

} // namespace volcaustic::viewer
