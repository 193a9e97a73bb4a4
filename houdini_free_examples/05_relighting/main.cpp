// Relighting: a session runs only what a change touches, and writes a sequence that Blender plays.
// Usage: 05_relighting [RESOLUTION]   writes relit.0001.vdb to relit.0008.vdb and relit.png into the current folder.
#include <volcaustic/volcaustic.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace vc = volcaustic;

namespace {

constexpr int kFrames = 8;

vc::Scene scene(int resolution) {
  vc::Scene s;
  s.volume.automatic = false;
  s.volume.bounds = {{-1, -1, -1}, {1, 1, 1}};
  s.volume.resolution = resolution;
  s.volume.ambient.attenuation = s.volume.ambient.scattering = {.3, .3, .3};
  vc::SceneObject ball;
  ball.name = "ball";
  ball.shape = vc::Shape::sphere(.4);
  s.objects = {ball};
  vc::Light sun;
  sun.name = "sun";
  sun.irradiance = {4, 3.8, 3.5};
  s.lights = {sun};
  s.photons.grid = {4 * resolution, 4 * resolution};
  s.camera.position = {0, -5, 1};
  s.camera.resolution = {320, 240};
  return s;
}

/// The sun sinks from the zenith by ten degrees a frame.
void turnSun(vc::Scene& s, int frame) {
  const double angle = (frame - 1) * 3.14159265358979 / 18;
  s.lights[0].direction = {std::sin(angle), 0, -std::cos(angle)};
}

/// How often a stage has run.
int runs(const vc::Session& session, const char* stage) {
  int count = 0;
  for (const vc::StageRun& run : session.runs()) count += run.stage == stage;
  return count;
}

int run(int resolution) {
  vc::Session session(scene(resolution));
  for (int frame = 1; frame <= kFrames; ++frame) {
    vc::Scene next = session.scene();
    turnSun(next, frame);
    session.setScene(next);
    const std::size_t before = session.runs().size();
    vc::writeVdb("relit.000" + std::to_string(frame) + ".vdb", session.photons(), session.medium());
    std::printf("frame %d:", frame);
    for (std::size_t i = before; i < session.runs().size(); ++i) {
      const vc::StageRun& stage = session.runs()[i];
      std::printf(" %s %.0f ms", stage.stage.c_str(), stage.milliseconds);
      for (const std::string& place : stage.because) std::printf(" (%s)", place.c_str());
    }
    std::printf("\n");
  }
  vc::writeImage("relit.png", session.view().image);
  const bool once = runs(session, "medium") == 1 && runs(session, "stepField") == 1;
  const bool each = runs(session, "photons") == kFrames && runs(session, "view") == 1;
  std::printf("medium built %d time, photons sent %d times\n", runs(session, "medium"), runs(session, "photons"));
  return once && each ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? std::atoi(argv[1]) : 128);
  } catch (const vc::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
