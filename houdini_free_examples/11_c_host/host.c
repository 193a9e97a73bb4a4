/* A host in plain C that knows nothing of volcaustic when it is built: it loads libvolcaustic_c.so, gives it a scene as
   text, shows progress, and takes a grid and a picture.
   Usage: 11_c_host [LIBRARY]   writes c_host.vdb and c_host.exr into the current folder. */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volcaustic_c.h>

static const char* const kScene =
    "{ \"volcaustic\": 1,"
    "  \"volume\": { \"bounds\": { \"min\": [-1, -1, -2], \"max\": [1, 1, 1] }, \"resolution\": 120,"
    "                \"attenuation\": [0.1, 0.1, 0.1], \"scattering\": [0.1, 0.1, 0.1] },"
    "  \"objects\": [{ \"shape\": { \"type\": \"ellipsoid\", \"semiAxes\": [0.6, 0.6, 0.6] } }],"
    "  \"lights\": [{ \"direction\": [0, 0, -1], \"irradiance\": [3, 3, 3] }],"
    "  \"photons\": { \"grid\": [256, 256] },"
    "  \"camera\": { \"position\": [0, -8, -0.5], \"target\": [0, 0, -0.5], \"resolution\": [240, 320] } }";

/* What this host needs of the interface. */
typedef struct Api {
  uint32_t (*interface)(void);
  const char* (*version)(void);
  const char* (*message)(void);
  volcaustic_session* (*open)(const volcaustic_scene*, const volcaustic_options*, volcaustic_status*);
  void (*close)(volcaustic_session*);
  size_t (*grid_count)(volcaustic_session*, volcaustic_stage);
  volcaustic_status (*grid_at)(volcaustic_session*, volcaustic_stage, size_t, volcaustic_grid*);
  volcaustic_status (*read_grid)(volcaustic_session*, volcaustic_stage, const char*, const int32_t*, const int32_t*,
                                 float*, size_t);
  volcaustic_status (*write)(volcaustic_session*, volcaustic_stage, const char*, uint32_t);
} Api;

/* POSIX lets dlsym's pointer to data be one to a function; ISO C wants it copied. */
static int find(void* library, const char* name, void* function) {
  void* found = dlsym(library, name);
  memcpy(function, &found, sizeof found);
  return found != NULL;
}

static int load(const char* path, Api* api) {
  void* library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  if (!library) {
    fprintf(stderr, "11_c_host: %s; give the library's path as argument\n", dlerror());
    return 0;
  }
  if (!find(library, "volcaustic_interface", &api->interface) || api->interface() < VOLCAUSTIC_C_INTERFACE ||
      !find(library, "volcaustic_version", &api->version) || !find(library, "volcaustic_message", &api->message) ||
      !find(library, "volcaustic_open", &api->open) || !find(library, "volcaustic_close", &api->close) ||
      !find(library, "volcaustic_grid_count", &api->grid_count) ||
      !find(library, "volcaustic_grid_at", &api->grid_at) || !find(library, "volcaustic_read_grid", &api->read_grid) ||
      !find(library, "volcaustic_write", &api->write)) {
    fprintf(stderr, "11_c_host: %s: is older than this host; install a newer volcaustic\n", path);
    return 0;
  }
  printf("volcaustic %s, interface %u\n", api->version(), (unsigned)api->interface());
  return 1;
}

/* Called from any thread, one at a time. */
static int32_t show_progress(void* user, const char* stage, double fraction) {
  int* calls = user;
  if (++*calls % 16 == 1) printf("  %-10s %3.0f %%\n", stage, 100 * fraction);
  return 0; /* anything else cancels */
}

/* The brightest voxel below the ball, on its axis: spherical aberration draws it nearer than the paraxial focus. */
static int find_focus(const Api* api, volcaustic_session* session) {
  volcaustic_grid grid;
  size_t i = 0;
  const size_t count = api->grid_count(session, VOLCAUSTIC_PHOTONS);
  do {
    if (i == count || api->grid_at(session, VOLCAUSTIC_PHOTONS, i, &grid) != VOLCAUSTIC_OK) return 0;
    ++i;
  } while (strcmp(grid.name, "radiance") != 0);

  const int32_t first[3] = {grid.dims[0] / 2, grid.dims[1] / 2, 0}, size[3] = {1, 1, grid.dims[2]};
  float* column = malloc(sizeof *column * 3 * (size_t)size[2]);
  if (!column ||
      api->read_grid(session, VOLCAUSTIC_PHOTONS, grid.name, first, size, column, 3 * (size_t)size[2]) != VOLCAUSTIC_OK) {
    free(column);
    return 0;
  }
  double brightest = 0, depth = 0;
  for (int32_t z = 0; z < size[2]; ++z) {
    const double height = grid.min_corner[2] + (z + 0.5) * grid.voxel_size;
    if (height < -0.6 && column[3 * z] > brightest) {
      brightest = column[3 * z];
      depth = -height;
    }
  }
  free(column);
  const double focus = 1.5 * 2 * 0.6 / (4 * (1.5 - 1));
  printf("brightest voxel on the axis: %.3f %s, %.3f behind the centre; paraxial focus nD/(4(n-1)) = %.3f\n", brightest,
         grid.unit, depth, focus);
  return depth > 0.6 && depth < focus;
}

int main(int argc, char** argv) {
  Api api;
  if (!load(argc > 1 ? argv[1] : "libvolcaustic_c.so.1", &api)) return 4;

  int calls = 0;
  volcaustic_options options;
  memset(&options, 0, sizeof options);
  options.size = sizeof options;
  options.progress = show_progress;
  options.user = &calls;
  volcaustic_scene scene;
  memset(&scene, 0, sizeof scene);
  scene.size = sizeof scene;
  scene.json = kScene;
  volcaustic_session* session = api.open(&scene, &options, NULL);
  const int good = session && find_focus(&api, session) &&
                   api.write(session, VOLCAUSTIC_PHOTONS, "c_host.vdb", 0) == VOLCAUSTIC_OK &&
                   api.write(session, VOLCAUSTIC_VIEW, "c_host.exr", VOLCAUSTIC_HALF) == VOLCAUSTIC_OK && calls > 0;
  if (!good) fprintf(stderr, "11_c_host: %s\n", *api.message() ? api.message() : "the focus is not where it should be");
  api.close(session);
  return good ? 0 : 1;
}
