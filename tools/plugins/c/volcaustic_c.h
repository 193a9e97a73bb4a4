/** \file volcaustic_c.h
 *  volcaustic for hosts in any language: plain C, made to be loaded at run time (dlopen "libvolcaustic_c.so.1").
 *
 *  A session holds a scene and the latest results of its stages; a call runs what is missing and no more. A call that
 *  fails leaves results as they were, returns a status other than VOLCAUSTIC_OK (or null), and volcaustic_message() has
 *  one line for a person. Text is UTF-8 and ends in 0. Sessions may be used from any thread, one call at a time each;
 *  only volcaustic_cancel() may be called while another call runs. docs/c_interface.md has a program that uses it all.
 */
#ifndef VOLCAUSTIC_C_H
#define VOLCAUSTIC_C_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define VOLCAUSTIC_C_API __attribute__((visibility("default")))
#else
#define VOLCAUSTIC_C_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Of this header. Functions and fields at the end of structs are added; what there is stays as it is. */
#define VOLCAUSTIC_C_INTERFACE 1

/** What the library offers: a host whose header says more asks for a newer library. */
VOLCAUSTIC_C_API uint32_t volcaustic_interface(void);
/** Of volcaustic: "0.1.0". */
VOLCAUSTIC_C_API const char* volcaustic_version(void);

/** The exit statuses of the program, and VOLCAUSTIC_BAD_FILE. */
typedef enum volcaustic_status {
  VOLCAUSTIC_OK = 0,
  VOLCAUSTIC_OUR_FAULT = 1,
  VOLCAUSTIC_WRONG_USAGE = 2,
  VOLCAUSTIC_BAD_INPUT = 3, /**< the content of a scene or of a file that it names */
  VOLCAUSTIC_NO_DEVICE = 4,
  VOLCAUSTIC_BAD_FILE = 5, /**< cannot be opened, read or written */
  VOLCAUSTIC_CANCELLED = 130
} volcaustic_status;

/** What the latest call of this thread that failed has to say; never null, valid until the next call that fails. */
VOLCAUSTIC_C_API const char* volcaustic_message(void);

typedef enum volcaustic_log_level {
  VOLCAUSTIC_LOG_DETAIL = 0,
  VOLCAUSTIC_LOG_INFO = 1,
  VOLCAUSTIC_LOG_WARNING = 2
} volcaustic_log_level;

/** How to run. Begin with all bytes 0 and set `size`. Callbacks come from any thread, one at a time; of the session
 *  they may call volcaustic_cancel() alone, all else is refused. */
typedef struct volcaustic_options {
  size_t size;           /**< sizeof(volcaustic_options) */
  int32_t threads;       /**< to 4096; 0: all */
  uint64_t seed;         /**< selects the jitter */
  uint64_t memory_limit; /**< bytes; 0: three quarters of the machine's */
  const char* device;    /**< "auto" (null), "cpu", "cuda", ... as the program's --device */
  const char* cache;     /**< folder for light and pictures that outlive the session; null: none */
  /** `fraction` of `stage` is done, 0 to 1; other than 0 cancels the call that it is in. */
  int32_t (*progress)(void* user, const char* stage, double fraction);
  void (*log)(void* user, int32_t level, const char* line);
  void* user; /**< for the callbacks */
} volcaustic_options;

/** A scene: text or a file. Begin with all bytes 0 and set `size`. */
typedef struct volcaustic_scene {
  size_t size;             /**< sizeof(volcaustic_scene) */
  const char* json;        /**< the text of a scene file; null: read `path` */
  const char* path;        /**< a scene file (.json, .volcaustic, .gltf, .glb), or the name and folder of `json` */
  const char* const* sets; /**< "photons.grid=[512,512]", as the program's --set */
  size_t set_count;
  double frame;       /**< at which it is evaluated */
  const char* camera; /**< of a glTF file, by name; null: the first */
  int32_t box_of_all; /**< 1: an automatic box is that of all frames, so that voxels stay where they are */
} volcaustic_scene;

typedef struct volcaustic_session volcaustic_session;

/** Checks the scene, runs nothing. Null where it fails; status, where not null, says why. `options` may be null. */
VOLCAUSTIC_C_API volcaustic_session* volcaustic_open(const volcaustic_scene* scene, const volcaustic_options* options,
                                                     volcaustic_status* status);
/** Null is allowed. */
VOLCAUSTIC_C_API void volcaustic_close(volcaustic_session* session);
/** Another scene, or another frame of it: results that it does not touch stay. */
VOLCAUSTIC_C_API volcaustic_status volcaustic_set_scene(volcaustic_session* session, const volcaustic_scene* scene);
/** First and last frame, and frames per second; pointers may be null. */
VOLCAUSTIC_C_API volcaustic_status volcaustic_frames(volcaustic_session* session, int32_t* first, int32_t* last,
                                                     double* rate);
/** The call that runs ends soon with VOLCAUSTIC_CANCELLED; where none runs, the next does. From any thread. */
VOLCAUSTIC_C_API void volcaustic_cancel(volcaustic_session* session);

typedef enum volcaustic_stage {
  VOLCAUSTIC_MEDIUM = 0,  /**< index, attenuation, scattering, coverage */
  VOLCAUSTIC_PHOTONS = 1, /**< the light in it */
  VOLCAUSTIC_VIEW = 2     /**< the picture */
} volcaustic_stage;
/** Runs a stage and those before it. The functions below do so, too, when they are asked for its result. */
VOLCAUSTIC_C_API volcaustic_status volcaustic_run(volcaustic_session* session, volcaustic_stage stage);

/** A grid of the medium (index, attenuation, scattering, coverage, asymmetry) or of the light (radiance, caustic,
 * direct, direction, emission, density, and of each light by itself). */
typedef struct volcaustic_grid {
  const char* name; /**< valid until the session is closed */
  const char* unit; /**< "W/(m2 sr)", "1/world", "1" */
  int32_t components;
  int32_t dims[3];      /**< voxels of the domain */
  double min_corner[3]; /**< world; of voxel (0, 0, 0), whose centre is half a voxel further */
  double voxel_size;    /**< world */
} volcaustic_grid;
/** How many grids a stage makes, VOLCAUSTIC_MEDIUM or VOLCAUSTIC_PHOTONS; 0 where it fails. To say what they are takes
 *  the medium, and no photons. */
VOLCAUSTIC_C_API size_t volcaustic_grid_count(volcaustic_session* session, volcaustic_stage stage);
VOLCAUSTIC_C_API volcaustic_status volcaustic_grid_at(volcaustic_session* session, volcaustic_stage stage, size_t index,
                                                      volcaustic_grid* grid);
/** Copies a box of voxels, x fastest, then y, then z, components together. `out` has size[0]*size[1]*size[2]*components
 *  numbers, and `out_count` says so. */
VOLCAUSTIC_C_API volcaustic_status volcaustic_read_grid(volcaustic_session* session, volcaustic_stage stage,
                                                        const char* name, const int32_t first[3], const int32_t size[3],
                                                        float* out, size_t out_count);

/** The picture, scene-linear Rec. 709. Nothing is run for it: what it will be is known before. */
typedef struct volcaustic_picture {
  int32_t width, height, channels;
} volcaustic_picture;
VOLCAUSTIC_C_API volcaustic_status volcaustic_picture_of(volcaustic_session* session, volcaustic_picture* picture);
/** "R", "caustic.G", ...; null beyond the last. Valid until the scene is set or the session closed. */
VOLCAUSTIC_C_API const char* volcaustic_channel(volcaustic_session* session, int32_t channel);
/** Copies the picture, rows from the top, the channels of a pixel together. `out` has width*height*channels numbers. */
VOLCAUSTIC_C_API volcaustic_status volcaustic_read_picture(volcaustic_session* session, float* out, size_t out_count);

/** Flags of volcaustic_write(). */
#define VOLCAUSTIC_HALF 1u  /**< 16-bit floats, .vdb and .exr */
#define VOLCAUSTIC_PARTS 2u /**< also the grids caustic and direct */
/** Writes the medium or the light as .vdb or .nvdb, the picture as .exr, .png, ...: whole or not at all. */
VOLCAUSTIC_C_API volcaustic_status volcaustic_write(volcaustic_session* session, volcaustic_stage stage,
                                                    const char* path, uint32_t flags);

#ifdef __cplusplus
}
#endif

#endif
