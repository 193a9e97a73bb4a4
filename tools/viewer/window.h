// A window with OpenGL and Dear ImGui in it.
#pragma once

#include "display.h"
#include "view_geometry.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

struct GLFWwindow;

namespace volcaustic::viewer {

/// A key that went down.
struct KeyPress {
  int key = 0; ///< GLFW's number
  bool control = false;
};

/// What a script does with mouse and keyboard in one frame, in place of a person.
struct ScriptedInput {
  std::optional<Point> mouse;
  std::array<bool, 3> buttons{}; ///< left, right, middle
  double wheel = 0;
  std::vector<KeyPress> keys;
};

class Window {
public:
  /// \throws Error(Device) when there is no display, or no OpenGL 3.0 on it.
  Window(int width, int height, const std::string& title);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  [[nodiscard]] bool isClosed() const;
  void close();
  void setTitle(const std::string& title);
  /// Between both, Dear ImGui takes calls. With `input`, mouse and keyboard of a person do not count.
  void beginFrame(const ScriptedInput* input);
  /// Keys that went down since the frame before, however short.
  [[nodiscard]] const std::vector<KeyPress>& keys() const { return mKeys; }
  /// Draws and shows the frame.
  void endFrame();
  /// The frame that was drawn last.
  [[nodiscard]] Pixels pixels() const;

private:
  GLFWwindow* mWindow = nullptr;
  std::vector<KeyPress> mKeys;
  Pixels mPixels;
};

/// A picture in the memory of the graphics card, drawn by ImGui::Image.
class Texture {
public:
  Texture();
  ~Texture();
  Texture(const Texture&) = delete;
  Texture& operator=(const Texture&) = delete;

  /// \param sharp nearest pixels when enlarged, else interpolated
  void set(const Pixels& pixels, bool sharp);
  [[nodiscard]] void* id() const;
  [[nodiscard]] int width() const { return mWidth; }
  [[nodiscard]] int height() const { return mHeight; }

private:
  unsigned mName = 0;
  int mWidth = 0, mHeight = 0;
};

} // namespace volcaustic::viewer
