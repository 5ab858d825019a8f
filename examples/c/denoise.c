/* Denoises a made-up render through the C interface: a lit wall with tiles, 8 samples a pixel, each as noisy
 * as path tracing is. Prints the error before and after and writes the picture as a PFM: denoise_c
 * WEIGHTS.safetensors [PICTURE.pfm] */
#include <layered_denoiser/layered_denoiser.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 96, HEIGHT = 64, SPP = 8 };

static float uniform(void) {
  return (float)rand() / (float)RAND_MAX;
}

/* What a feature of one pixel is; features of which this scene has none stay 0. */
static void shade(const char* name, int x, int y, float* channels) {
  const float albedo = ((x / 12 + y / 12) % 2 != 0) ? 0.8F : 0.3F;
  if (strcmp(name, "albedo") == 0) channels[0] = channels[1] = channels[2] = albedo;
  if (strcmp(name, "normal") == 0) channels[2] = 1;
  if (strcmp(name, "depth") == 0) channels[0] = 4;
  if (strcmp(name, "roughness") == 0) channels[0] = 1;
  if (strcmp(name, "radiance") == 0) {
    const float light = 1 - 0.6F * (float)x / WIDTH;
    channels[0] = albedo * light;
    channels[1] = albedo * light * 0.9F;
    channels[2] = albedo * light * 0.7F;
  }
}

/* All samples of a feature, [SPP][channels][HEIGHT][WIDTH]. A path reaches the lamp or not: noise of mean 1.
 */
static float* make_samples(const char* name, int channels) {
  float* data = calloc((size_t)SPP * channels * HEIGHT * WIDTH, sizeof(float));
  if (data == NULL) return NULL;
  for (int s = 0; s < SPP; ++s)
    for (int y = 0; y < HEIGHT; ++y)
      for (int x = 0; x < WIDTH; ++x) {
        float value[3] = {0, 0, 0};
        shade(name, x, y, value);
        const float reached = strcmp(name, "radiance") != 0 ? 1.0F : uniform() < 0.25F ? 4.0F : 0.0F;
        for (int c = 0; c < channels; ++c)
          data[(((size_t)s * channels + c) * HEIGHT + y) * WIDTH + x] = value[c] * reached;
      }
  return data;
}

static double error_of(const float* picture) {
  double sum = 0;
  for (int y = 0; y < HEIGHT; ++y)
    for (int x = 0; x < WIDTH; ++x) {
      float truth[3];
      shade("radiance", x, y, truth);
      for (int c = 0; c < 3; ++c) {
        const double difference = picture[(c * HEIGHT + y) * WIDTH + x] - truth[c];
        sum += difference * difference;
      }
    }
  return sqrt(sum / (3.0 * WIDTH * HEIGHT));
}

/* Portable float map: rows from the bottom up. */
static int write_pfm(const char* path, const float* picture) {
  FILE* file = fopen(path, "wb");
  if (file == NULL) return 0;
  fprintf(file, "PF\n%d %d\n-1.0\n", WIDTH, HEIGHT);
  for (int y = HEIGHT - 1; y >= 0; --y)
    for (int x = 0; x < WIDTH; ++x)
      for (int c = 0; c < 3; ++c) fwrite(&picture[(c * HEIGHT + y) * WIDTH + x], sizeof(float), 1, file);
  return fclose(file) == 0;
}

static int show(double share, void* user) {
  *(double*)user = share;
  return 1; /* 0 would cancel */
}

int main(int argc, char** argv) {
  if (argc < 2) {
    fprintf(stderr, "usage: %s WEIGHTS.safetensors [PICTURE.pfm]\n", argv[0]);
    return 2;
  }
  LdDenoiser* denoiser = NULL;
  if (ld_create(argv[1], &denoiser) != LD_OK || ld_set_size(denoiser, WIDTH, HEIGHT, SPP) != LD_OK) {
    fprintf(stderr, "%s\n", ld_error());
    return 1;
  }
  printf("layered_denoiser %s\n", ld_version());

  float* buffers[16] = {NULL};
  static float noisy[3 * HEIGHT * WIDTH], denoised[3 * HEIGHT * WIDTH];
  for (int i = 0; i < ld_feature_count(denoiser) && i < 16; ++i) {
    const char* name = ld_feature_name(denoiser, i);
    buffers[i] = make_samples(name, ld_feature_channels(denoiser, i));
    if (strcmp(name, "radiance") == 0)
      for (int s = 0; s < SPP; ++s)
        for (int k = 0; k < 3 * HEIGHT * WIDTH; ++k) noisy[k] += buffers[i][s * 3 * HEIGHT * WIDTH + k] / SPP;
    if (ld_set_feature(denoiser, name, buffers[i], NULL) != LD_OK) fprintf(stderr, "%s\n", ld_error());
  }

  double done = 0;
  ld_set_progress(denoiser, show, &done);
  const LdStatus status = ld_denoise(denoiser, denoised, NULL);
  if (status != LD_OK)
    fprintf(stderr, "%s\n", ld_error());
  else
    printf("error of the noisy picture %.4f, denoised %.4f, progress %.0f %%\n", error_of(noisy),
           error_of(denoised), 100 * done);
  const int written = status == LD_OK && (argc < 3 || write_pfm(argv[2], denoised));
  for (int i = 0; i < 16; ++i) free(buffers[i]);
  ld_destroy(denoiser);
  return written && error_of(denoised) < error_of(noisy) ? 0 : 1;
}
