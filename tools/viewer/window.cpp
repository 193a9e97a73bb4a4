#include "window.h"

#include <volcaustic/error.h>

#include <algorithm>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <cstring>
#include <GLFW/glfw3.h>
#include <imgui.h>

namespace volcaustic::viewer {

namespace {

std::string gGlfwError;
std::vector<KeyPress> gPressed; // since the last frame; Dear ImGui 1.86 does not see what is shorter than a frame

void setStyle(float scale) {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowBorderSize = 0;
  style.Colors[ImGuiCol_WindowBg] = {.11f, .115f, .125f, 1};
  style.Colors[ImGuiCol_FrameBg] = {.19f, .2f, .22f, 1};
  style.Colors[ImGuiCol_Header] = {.2f, .29f, .36f, 1};
  style.Colors[ImGuiCol_Button] = {.21f, .3f, .38f, 1};
  style.Colors[ImGuiCol_SliderGrab] = style.Colors[ImGuiCol_CheckMark] = {.95f, .7f, .3f, 1};
  style.ScaleAllSizes(scale);
  ImFontConfig font;
  font.SizePixels = 15 * scale;
  ImGui::GetIO().Fonts->AddFontDefault(&font);
}

} // namespace

Window::Window(int width, int height, const std::string& title) {
  glfwSetErrorCallback([](int, const char* text) { gGlfwError = text; });
  if (!glfwInit())
    throw Error(ErrorKind::Device, "view: no display: " + gGlfwError + "; set DISPLAY, or run it under xvfb-run");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 0);
  mWindow = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!mWindow) {
    glfwTerminate();
    throw Error(ErrorKind::Device, "view: no window with OpenGL 3.0: " + gGlfwError +
                                       "; LIBGL_ALWAYS_SOFTWARE=1 draws without a graphics card");
  }
  glfwMakeContextCurrent(mWindow);
  glfwSwapInterval(1);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr; // the layout is always the same, and no file is left behind
  float scale = 1;
  glfwGetWindowContentScale(mWindow, &scale, nullptr);
  setStyle(scale);
  glfwSetKeyCallback(mWindow, [](GLFWwindow*, int key, int, int action, int modifiers) {
    if (action == GLFW_PRESS) gPressed.push_back({key, (modifiers & GLFW_MOD_CONTROL) != 0});
  });
  ImGui_ImplGlfw_InitForOpenGL(mWindow, true);
  ImGui_ImplOpenGL3_Init("#version 130");
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(mWindow);
  glfwTerminate();
}

bool Window::isClosed() const { return glfwWindowShouldClose(mWindow); }
void Window::close() { glfwSetWindowShouldClose(mWindow, GLFW_TRUE); }
void Window::setTitle(const std::string& title) { glfwSetWindowTitle(mWindow, title.c_str()); }

void Window::beginFrame(const ScriptedInput* input) {
  gPressed.clear();
  glfwPollEvents();
  mKeys = input ? input->keys : gPressed;
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  if (input) {
    ImGuiIO& io = ImGui::GetIO();
    if (input->mouse) io.MousePos = {static_cast<float>((*input->mouse)[0]), static_cast<float>((*input->mouse)[1])};
    for (int b = 0; b < 3; ++b) io.MouseDown[b] = input->buttons[b];
    io.MouseWheel = static_cast<float>(input->wheel);
    std::fill(std::begin(io.KeysDown), std::end(io.KeysDown), false);
  }
  ImGui::NewFrame();
}

void Window::endFrame() {
  ImGui::Render();
  int width = 0, height = 0;
  glfwGetFramebufferSize(mWindow, &width, &height);
  glViewport(0, 0, width, height);
  glClearColor(.07f, .07f, .08f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  // What is on the screen belongs to the screen: read it before it is handed over.
  mPixels.width = width;
  mPixels.height = height;
  mPixels.rgba.resize(std::size_t(width) * static_cast<std::size_t>(height) * 4);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, mPixels.rgba.data());
  glfwSwapBuffers(mWindow);
}

Pixels Window::pixels() const {
  Pixels upright = mPixels; // OpenGL's rows begin at the bottom
  const std::size_t row = std::size_t(mPixels.width) * 4;
  for (int y = 0; y < mPixels.height; ++y)
    std::memcpy(upright.rgba.data() + static_cast<std::size_t>(y) * row,
                mPixels.rgba.data() + static_cast<std::size_t>(mPixels.height - 1 - y) * row, row);
  return upright;
}

Texture::Texture() { glGenTextures(1, &mName); }
Texture::~Texture() { glDeleteTextures(1, &mName); }

void Texture::set(const Pixels& pixels, bool sharp) {
  mWidth = pixels.width;
  mHeight = pixels.height;
  glBindTexture(GL_TEXTURE_2D, mName);
  const GLint filter = sharp ? GL_NEAREST : GL_LINEAR;
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, 0x812F /* GL_CLAMP_TO_EDGE of OpenGL 1.2 */);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, mWidth, mHeight, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels.rgba.data());
}

void* Texture::id() const { return reinterpret_cast<void*>(static_cast<std::uintptr_t>(mName)); }

} // namespace volcaustic::viewer
