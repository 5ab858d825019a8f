/* Denoises frames of Monte Carlo samples with weights that ld_train or ld_export wrote: the C interface.
 * layered_denoiser.hpp wraps it for C++. Neither needs a header of LibTorch.
 *
 *   LdDenoiser* denoiser = NULL;
 *   if (ld_create("layer.safetensors", &denoiser) != LD_OK) { puts(ld_error()); return 1; }
 *   ld_set_size(denoiser, width, height, spp);
 *   ld_set_feature(denoiser, "radiance", radiance, NULL);   one call for each name of ld_feature_name()
 *   if (ld_denoise(denoiser, picture, NULL) != LD_OK) puts(ld_error());
 *   ld_destroy(denoiser);
 *
 * Units, axes and signs of the features stand in docs/data_format.md: radiance is linear and scene-referred,
 * normals are in view space, depth is 65504 where the ray escaped.
 *
 * Threads: one denoiser must not be used by two threads at once; two denoisers may. The work inside one call
 * runs on ld_set_threads() threads. */
#ifndef LAYERED_DENOISER_H
#define LAYERED_DENOISER_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define LD_API __attribute__((visibility("default")))
#else
#define LD_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef struct LdDenoiser LdDenoiser;

typedef enum LdStatus {
  LD_OK = 0,
  LD_INVALID_ARGUMENT = 1, /* the caller's mistake: an unknown feature, a missing buffer, a size of 0, too
                              small a memory bound */
  LD_FAILED = 2,           /* a missing or damaged weight file, no memory */
  LD_CANCELLED = 3         /* the progress function asked to stop; the output was not touched */
} LdStatus;

/* Where the numbers of a buffer lie, in floats: sample s, channel c, row y, column x is at
 * data[s * sample + c * channel + y * row + x * pixel]. NULL where one is asked for means planes one after
 * the other: [spp][channels][height][width] for features, [3][height][width] for the picture. */
typedef struct LdStrides {
  ptrdiff_t sample, channel, row, pixel;
} LdStrides;

/* What was left out of a frame's work, as shares, 0 to 1: of the pixels, those whose light is even; of what
 * networks make of each sample, the samples that are the first of their pixel again; of the pixels of layers,
 * those without influence. */
typedef struct LdSkipped {
  double pixels, samples, layers;
} LdSkipped;

/* Called now and then with the share that is done, 0 to 1; returning 0 cancels. */
typedef int (*LdProgress)(double share, void* user);

/* "0.1.0" */
LD_API const char* ld_version(void);

/* What went wrong in the last call of this thread that did not return LD_OK, one line; "" before the first.
 * Stays valid until this thread's next call. */
LD_API const char* ld_error(void);

/* Threads of all denoisers of this process from the next call on; 0: the CPUs that it may use (the default).
 */
LD_API LdStatus ld_set_threads(int threads);

/* Loads a weight file (.safetensors), a checkpoint folder or a run folder. `*denoiser` is NULL on failure.
 * Networks that remember ("layer_history") take every ld_denoise() for the next frame of a sequence, until
 * ld_restart() or another size. */
LD_API LdStatus ld_create(const char* weights, LdDenoiser** denoiser);

/* A denoiser without weights: "eaw" (Dammertz et al. 2010) or "svgf" (Schied et al. 2017), with `settings` of
 * the form "key=value", the last one NULL; NULL: the defaults (docs/filters.md). "svgf" remembers, too. */
LD_API LdStatus ld_create_filter(const char* kind, const char* const* settings, LdDenoiser** denoiser);
LD_API void ld_destroy(LdDenoiser* denoiser); /* NULL is fine */

/* The features that these weights or this filter read. All must be set before ld_denoise(), but for those
 * that the weights do without (network.optional of their training): of the released ones and filters, all but
 * "radiance". ld_denoise() names one that is missing. */
LD_API int ld_feature_count(const LdDenoiser* denoiser);
LD_API const char* ld_feature_name(const LdDenoiser* denoiser, int index); /* NULL beyond the count */
LD_API int ld_feature_channels(const LdDenoiser* denoiser, int index);     /* 0 beyond the count */

/* Size of the following frames, in pixels and samples a pixel, from 1. Forgets all buffers. */
LD_API LdStatus ld_set_size(LdDenoiser* denoiser, int width, int height, int spp);

/* The samples of a feature. The memory stays the caller's and is read by ld_denoise(). Samples with a NaN or
 * an infinity are left out as if they had not been drawn. */
LD_API LdStatus ld_set_feature(LdDenoiser* denoiser, const char* name, const float* data,
                               const LdStrides* strides);

/* Parts of the light (what single lamps send, diffuse and specular, direct and indirect): each call adds one.
 * `samples` are its radiance [spp][3][height][width], which may be negative. ld_denoise() filters it with the
 * weights of the picture and writes [3][height][width] to `picture` when it succeeds. Parts that sum to the
 * radiance in every sample so come out as parts that sum to the picture, to rounding, whose bits they do not
 * change. A part with a NaN or an infinity where the radiance has none counts as 0 in that sample. Both
 * memories stay the caller's. ld_set_size() forgets the parts. */
LD_API LdStatus ld_add_part(LdDenoiser* denoiser, const float* samples, const LdStrides* strides,
                            float* picture, const LdStrides* picture_strides);

/* The same for the samples' alpha, [spp][1][height][width], 0 to 1, the radiance premultiplied by it;
 * `picture` receives [1][height][width]. Samples whose alpha is a NaN or an infinity are left out. */
LD_API LdStatus ld_set_alpha(LdDenoiser* denoiser, const float* samples, const LdStrides* strides,
                             float* picture, const LdStrides* picture_strides);

/* Which samples were drawn, [spp][height][width], 0 for no; NULL (the default): all. */
LD_API LdStatus ld_set_valid(LdDenoiser* denoiser, const uint8_t* valid);

/* Bounds what the whole process takes while ld_denoise() runs, in MB of 2^20 bytes: program, libraries and
 * your own memory count. The samples are read where they lie. 0 (the default): no bound. The bound
 * changes no bit of the picture. One that is too small makes ld_denoise() fail and name the smallest one;
 * filters cannot keep any. */
LD_API LdStatus ld_set_max_memory(LdDenoiser* denoiser, size_t megabytes);

/* How far the picture x may be from that of all work, so that what is known beforehand need not be computed:
 * in each channel by at most within (1 + |x|), in parts of the light and alpha, too. `within` is 0 to 1; 0
 * (the default): by no bit. What was left out of the last frame, ld_skipped() says. Networks that remember,
 * blend resolutions or predict light leave out what keeps every bit; filters leave out nothing. */
LD_API LdStatus ld_set_skip_within(LdDenoiser* denoiser, double within);
LD_API LdSkipped ld_skipped(const LdDenoiser* denoiser);

/* Of the following frames, for filters: the matrices that OpenEXR has as worldToCamera and worldToNDC, 16
 * numbers row by row for points as rows, at shutter open; NULL (the default): not known. Models do not read
 * them. */
LD_API LdStatus ld_set_camera(LdDenoiser* denoiser, const float* world_to_camera, const float* world_to_ndc);

/* The next frame follows none of those before, as after a cut. */
LD_API LdStatus ld_restart(LdDenoiser* denoiser);

/* 1 where frames have something of those before, 0 where each is denoised by itself. */
LD_API int ld_remembers(const LdDenoiser* denoiser);

/* NULL (the default): none. Filters are done before they could report. */
LD_API LdStatus ld_set_progress(LdDenoiser* denoiser, LdProgress progress, void* user);

/* Denoises the frame into `picture`: linear R, G, B. It is written only when the call succeeds. With the
 * same samples, weights, machine, number of threads and ld_set_skip_within(), the bits are those that the
 * program ld_denoise computes with --skip-within, whose default is 1e-4; its files hold them with --float. */
LD_API LdStatus ld_denoise(LdDenoiser* denoiser, float* picture, const LdStrides* strides);

#ifdef __cplusplus
}
#endif

#endif
