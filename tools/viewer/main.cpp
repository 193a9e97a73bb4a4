// volcaustic-view: the interactive window (docs/viewer.md). `volcaustic view` starts it.
#include "app.h"

#include <volcaustic/error.h>

#include <CLI/CLI.hpp>
#include <cstdio>

namespace {

int statusOf(volcaustic::ErrorKind kind) {
  switch (kind) {
  case volcaustic::ErrorKind::Usage:
    return 2;
  case volcaustic::ErrorKind::Input:
  case volcaustic::ErrorKind::File:
    return 3;
  case volcaustic::ErrorKind::Device:
    return 4;
  case volcaustic::ErrorKind::Cancelled:
    return 130;
  default:
    return 1;
  }
}

} // namespace

int main(int argc, char** argv) {
  volcaustic::viewer::ViewerOptions options;
  CLI::App app("Shows a scene in a window and lets a hand change it", "volcaustic view");
  app.add_option("SCENE", options.scene, "scene file (.json, .gltf, .glb)")->required();
  app.add_option("--set", options.read.sets,
                 "set any option of the scene first, as photons.grid=[512,512]; again for more")
      ->allow_extra_args(false);
  app.add_option("--frame", options.read.frame, "frame of the animation to begin with");
  app.add_option("--script", options.script, "commands in place of a hand, one a line (docs/viewer.md)");
  app.add_option("--width", options.width, "of the window, pixels")->check(CLI::Range(320, 16384));
  app.add_option("--height", options.height, "of the window, pixels")->check(CLI::Range(240, 16384));
  app.add_option("--device", options.context.device, "auto, cpu, cuda[:I] or hybrid");
  app.add_option("--threads", options.context.threads, "CPU threads; all if not given")->check(CLI::Range(0, 4096));
  app.add_option("--seed", options.context.seed, "of jittered photons and pixel samples");
  app.footer("Exit status: 0 done, 1 our fault, 2 wrong usage, 3 bad input, 4 no display or device.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return app.exit(help);
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "volcaustic view: %s; see `volcaustic view --help`\n", error.what());
    return 2;
  }
  try {
    volcaustic::viewer::App(std::move(options)).run();
    return 0;
  } catch (const volcaustic::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return statusOf(error.kind());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "volcaustic view: internal error: %s\n", error.what());
    return 1;
  }
}
