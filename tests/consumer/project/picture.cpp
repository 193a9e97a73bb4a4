// A picture through the module that the library loads: written as .png, read again.
#include <volcaustic/volcaustic.h>

#include <cmath>
#include <cstdio>

int main() {
  volcaustic::Image image{.width = 4, .height = 2};
  for (const char* channel : {"R", "G", "B"}) image.add(channel).assign(8, 0.25F);
  volcaustic::writeImage("picture.png", image);
  const volcaustic::Image back = volcaustic::readImage("picture.png");
  if (back.width == 4 && back.height == 2 && std::abs(back.planes.at(1).at(5) - 0.25F) < 0.01F) return 0;
  std::fprintf(stderr, "the picture is not what was written\n");
  return 1;
}
