#include "option_widgets.h"

#include <volcaustic/options.h>

#include <algorithm>
#include <cmath>
#include <imgui.h>
#include <imgui_stdlib.h>
#include <string>
#include <type_traits>
#include <vector>

namespace volcaustic::viewer {

namespace {

/// A visitor of describe().
class Widgets {
public:
  explicit Widgets(Edited& edited) : mEdited(edited) {}

  template <class T>
  void operator()(const char* name, T& value, const FieldDoc& doc) {
    ImGui::PushID(name);
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x * .56f);
    edit(name, value, doc);
    ImGui::PopID();
  }

private:
  void note(const char* name, const FieldDoc& doc, bool changed) {
    mEdited.changed |= changed;
    mEdited.finished |= ImGui::IsItemDeactivatedAfterEdit();
    hint(name, doc);
  }
  /// For widgets that have no drag: one click is the whole change.
  void noteClick(const char* name, const FieldDoc& doc, bool changed) {
    mEdited.changed |= changed;
    mEdited.finished |= changed;
    hint(name, doc);
  }
  static void hint(const char* name, const FieldDoc& doc) {
    if (!ImGui::IsItemHovered()) return;
    const std::string unit = *doc.unit ? std::string(" [") + doc.unit + "]" : "";
    ImGui::SetTooltip("%s%s: %s", name, unit.c_str(), doc.text);
  }

  void edit(const char* name, bool& v, const FieldDoc& doc) { noteClick(name, doc, ImGui::Checkbox(name, &v)); }
  void edit(const char* name, int& v, const FieldDoc& doc) {
    if (!doc.choices.empty()) {
      if (!ImGui::BeginCombo(name, std::to_string(v).c_str())) return hint(name, doc);
      for (const int choice : doc.choices)
        if (ImGui::Selectable(std::to_string(choice).c_str(), choice == v) && choice != v) {
          v = choice;
          mEdited.changed = mEdited.finished = true;
        }
      ImGui::EndCombo();
      return;
    }
    int before = v;
    const bool changed = ImGui::DragInt(name, &before, std::max(std::abs(static_cast<float>(v)) * .005f, .1f));
    if (changed) v = static_cast<int>(std::clamp(static_cast<double>(before), least(doc, -2e9), greatest(doc, 2e9)));
    note(name, doc, changed);
  }
  void edit(const char* name, double& v, const FieldDoc& doc) { numbers(name, &v, 1, doc); }
  template <std::size_t N>
  void edit(const char* name, std::array<double, N>& v, const FieldDoc& doc) {
    numbers(name, v.data(), N, doc);
  }
  template <std::size_t N>
  void edit(const char* name, std::array<int, N>& v, const FieldDoc& doc) {
    std::array<int, N> before = v;
    const bool changed = ImGui::DragScalarN(name, ImGuiDataType_S32, before.data(), N, 1);
    if (changed)
      for (std::size_t i = 0; i < N; ++i)
        v[i] = static_cast<int>(std::clamp(static_cast<double>(before[i]), least(doc, -2e9), greatest(doc, 2e9)));
    note(name, doc, changed);
  }
  void edit(const char* name, std::string& v, const FieldDoc& doc) { note(name, doc, ImGui::InputText(name, &v)); }
  /// Files are shown, not edited: a name half typed is no file.
  void edit(const char* name, std::filesystem::path& v, const FieldDoc& doc) {
    if (v.empty()) return;
    ImGui::TextDisabled("%s: %s", name, v.filename().string().c_str());
    hint(name, doc);
  }
  void edit(const char* name, Shape& v, const FieldDoc& doc) {
    if (v.empty()) return;
    ImGui::TextDisabled("%s: functional object", name);
    hint(name, doc);
  }
  void edit(const char* name, AutomaticBox& v, const FieldDoc& doc) {
    edit("automatic", v.automatic, {"the box is put around the objects"});
    if (v.automatic) return;
    edit("min", v.box.min, doc);
    edit("max", v.box.max, doc);
    hint(name, doc);
  }
  template <class T>
  void edit(const char* name, std::vector<T>& list, const FieldDoc& doc) {
    if constexpr (std::is_same_v<T, std::string>) {
      (void)list;
      hint(name, doc);
    } else {
      for (std::size_t i = 0; i < list.size(); ++i)
        if (ImGui::TreeNode((name + std::string(" ") + std::to_string(i)).c_str())) {
          describe(*this, list[i]);
          ImGui::TreePop();
        }
    }
  }
  template <class T>
  requires std::is_enum_v<T>
  void edit(const char* name, T& v, const FieldDoc& doc) {
    const auto names = enumNames(T{});
    int index = static_cast<int>(v);
    const bool changed = ImGui::Combo(name, &index, names.data(), static_cast<int>(names.size()));
    v = static_cast<T>(index);
    noteClick(name, doc, changed);
  }

  void numbers(const char* name, double* v, std::size_t n, const FieldDoc& doc) {
    double size = 0;
    for (std::size_t i = 0; i < n; ++i) size = std::max(size, std::abs(v[i]));
    const double range = doc.max - doc.min;
    const double speed = range < 1000 ? range * .002 : std::max(size * .005, .002);
    std::array<double, 4> before{};
    std::copy_n(v, n, before.data());
    const bool changed = ImGui::DragScalarN(name, ImGuiDataType_Double, before.data(), static_cast<int>(n),
                                            static_cast<float>(speed), nullptr, nullptr, "%.4g");
    if (changed)
      for (std::size_t i = 0; i < n; ++i) v[i] = std::clamp(before[i], least(doc, -1e300), greatest(doc, 1e300));
    note(name, doc, changed);
  }
  static double least(const FieldDoc& doc, double none) { return std::max(doc.min, none); }
  static double greatest(const FieldDoc& doc, double none) { return std::min(doc.max, none); }

  Edited& mEdited;
};

template <class T>
void section(const char* title, T& options, Edited& edited) {
  if (!ImGui::CollapsingHeader(title)) return;
  ImGui::PushID(title);
  Widgets widgets(edited);
  describe(widgets, options);
  ImGui::PopID();
}

template <class T>
void listOf(const char* title, std::vector<T>& list, Edited& edited) {
  if (!ImGui::CollapsingHeader(title)) return;
  ImGui::PushID(title);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string label = (list[i].name.empty() ? title : list[i].name) + "###" + std::to_string(i);
    if (!ImGui::TreeNode(label.c_str())) continue;
    Widgets widgets(edited);
    describe(widgets, list[i]);
    ImGui::TreePop();
  }
  ImGui::PopID();
}

} // namespace

Edited sceneWidgets(Scene& scene) {
  Edited edited;
  listOf("objects", scene.objects, edited);
  listOf("materials", scene.materials, edited);
  listOf("lights", scene.lights, edited);
  listOf("receivers", scene.receivers, edited);
  section("volume", scene.volume, edited);
  section("voxelise", scene.voxelise, edited);
  section("stepField", scene.stepField, edited);
  section("photons", scene.photons, edited);
  section("camera", scene.camera, edited);
  section("background", scene.background, edited);
  section("view", scene.view, edited);
  section("frames", scene.frames, edited);
  return edited;
}

} // namespace volcaustic::viewer
