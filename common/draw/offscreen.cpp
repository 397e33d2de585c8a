#define GL_GLEXT_PROTOTYPES
#include "draw/offscreen.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <cstdio>
#include <stdexcept>
#include <utility>

namespace draw {
namespace {

// Runs an action when the scope is left, by an exception too.
struct Finally {
  std::function<void()> action;
  explicit Finally(std::function<void()> a) : action(std::move(a)) {}
  Finally(const Finally&) = delete;
  Finally& operator=(const Finally&) = delete;
  ~Finally() { action(); }
};

// Mesa's surfaceless platform: an OpenGL context without window, display server or GPU.
class Egl {
 public:
  Egl() {
    display_ = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display_ == EGL_NO_DISPLAY) fail("eglGetPlatformDisplay");
    if (!eglInitialize(display_, nullptr, nullptr)) fail("eglInitialize");
    if (!eglBindAPI(EGL_OPENGL_API)) fail("eglBindAPI");
    constexpr EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                     3,
                                     EGL_CONTEXT_MINOR_VERSION,
                                     3,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                     EGL_NONE};
    context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (context_ == EGL_NO_CONTEXT) fail("eglCreateContext");
  }
  Egl(const Egl&) = delete;
  Egl& operator=(const Egl&) = delete;
  ~Egl() { close(); }

  void enter() {
    if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_)) {
      throw std::runtime_error(message("eglMakeCurrent"));
    }
  }
  void leave() { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

 private:
  static std::string message(const char* call) {
    char code[16];
    std::snprintf(code, sizeof code, "0x%x", static_cast<unsigned>(eglGetError()));
    return std::string("cannot draw pictures: ") + call + " failed (EGL error " + code +
           "); Mesa's EGL with OpenGL 3.3 is needed (packages libegl1 and libgl1-mesa-dri)";
  }
  [[noreturn]] void fail(const char* call) {
    const std::string what = message(call);
    close();
    throw std::runtime_error(what);
  }
  void close() {
    if (display_ == EGL_NO_DISPLAY) return;
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
    eglTerminate(display_);
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

// Kept for the process, since to start takes far longer than to draw a frame, and never destroyed,
// since at its end the driver may be unloaded before our objects are.
class Offscreen {
 public:
  Offscreen() {
    const Finally leave = enter();
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest_);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // write no file
    ImGui::GetStyle().AntiAliasedLinesUseTex = false;
    if (!ImGui_ImplOpenGL3_Init("#version 330")) {
      throw std::runtime_error("cannot draw pictures: OpenGL 3.3 functions are missing");
    }
    glGenFramebuffers(1, &framebuffer_);
    glGenTextures(1, &texture_);
  }
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;

  Image render(const Page& page, const std::function<void(Pen&)>& draw) {
    const Finally leave = enter();
    const int width = pixels(page.width, page.scale), height = pixels(page.height, page.scale);
    prepare_fonts(page.scale);
    prepare_target(width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
      throw std::runtime_error("cannot draw pictures: OpenGL offers no picture of " +
                               std::to_string(width) + " x " + std::to_string(height));
    }
    const Color paper = page.theme.paper;
    glViewport(0, 0, width, height);
    glClearColor(paper.r / 255.0F, paper.g / 255.0F, paper.b / 255.0F, 1);
    glClear(GL_COLOR_BUFFER_BIT);

    ImGui::GetIO().DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
    {
      const Finally end_frame([] { ImGui::EndFrame(); });
      Pen pen(ImGui::GetBackgroundDrawList(), fonts_, page.theme, page.width, page.height,
              page.scale);
      draw(pen);
    }
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    return read(width, height);
  }

 private:
  // Makes the contexts current, and gives a window's own Dear ImGui context back afterwards.
  [[nodiscard]] Finally enter() {
    egl_.enter();
    ImGuiContext* before = ImGui::GetCurrentContext();
    if (before == gui_) before = nullptr;
    ImGui::SetCurrentContext(gui_);
    return Finally([this, before] {
      ImGui::SetCurrentContext(before);
      egl_.leave();
    });
  }

  int pixels(int points, double scale) const {
    const double count = std::round(points * scale);
    if (count >= 1 && count <= largest_) return static_cast<int>(count);
    throw std::invalid_argument("a picture of " + std::to_string(points) + " points at scale " +
                                std::to_string(scale) + " has no side of 1 to " +
                                std::to_string(largest_) + " pixels");
  }

  void prepare_fonts(double scale) {
    if (scale == font_scale_) return;
    font_scale_ = 0;
    ImFontAtlas* atlas = ImGui::GetIO().Fonts;
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    atlas->Clear();
    fonts_ = load_fonts(scale);
    atlas->Build();
    if (std::max(atlas->TexWidth, atlas->TexHeight) > largest_) {
      throw std::invalid_argument("the fonts at scale " + std::to_string(scale) +
                                  " do not fit into a texture: use a smaller scale");
    }
    ImGui_ImplOpenGL3_CreateFontsTexture();
    font_scale_ = scale;
  }

  void prepare_target(int width, int height) {
    if (width == width_ && height == height_) return;
    width_ = width;
    height_ = height;
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_, 0);
  }

  static Image read(int width, int height) {
    const std::size_t row = 4 * static_cast<std::size_t>(width);
    Image image{width, height, std::vector<std::uint8_t>(row * static_cast<std::size_t>(height))};
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, image.rgba.data());
    // OpenGL counts rows from the bottom.
    for (auto top = image.rgba.begin(), bottom = image.rgba.end() - static_cast<long>(row);
         top < bottom; top += static_cast<long>(row), bottom -= static_cast<long>(row)) {
      std::swap_ranges(top, top + static_cast<long>(row), bottom);
    }
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    return image;
  }

  Egl egl_;
  ImGuiContext* gui_ = ImGui::CreateContext();
  GLint largest_ = 0;
  GLuint framebuffer_ = 0, texture_ = 0;
  int width_ = 0, height_ = 0;
  double font_scale_ = 0;
  Fonts fonts_{};
};

}  // namespace

Image render(const Page& page, const std::function<void(Pen&)>& draw) {
  static Offscreen& offscreen = *new Offscreen;
  return offscreen.render(page, draw);
}

}  // namespace draw
