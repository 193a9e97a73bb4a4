#include <volcaustic/volcaustic.h>
int main(int, char** argv) {
  volcaustic::Scene scene;
  scene.objects.emplace_back().meshFile = argv[1];
  scene.lights.emplace_back().direction = {0.3, 0, -1};
  volcaustic::Session session(scene);
  volcaustic::writeVdb("caustic.vdb", session.photons().radiance, session.medium());
}
