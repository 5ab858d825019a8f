// The state of torch::optim::Adam by parameter name. LibTorch's own archive applies neither learning rate nor
// betas when read back (1.13), and keys the state differently from version to version; that difference ends
// here.
#pragma once

#include <torch/torch.h>

#include "models/network.h"
#include "weights/model_file.h"

namespace ld {

/// "exp_avg.NAME" and "exp_avg_sq.NAME" of every parameter that has been stepped.
NamedTensors adam_state(torch::optim::Adam& optimizer, const Network& network);

/// Sets the state of all parameters as after `steps` steps. Throws Error when a tensor is missing or of
/// another shape; nothing has been set then.
void set_adam_state(torch::optim::Adam& optimizer, const Network& network, const SafetensorsFile& file,
                    int64_t steps);

/// Moments of 0 for all parameters, as after `steps` steps.
void make_adam_state(torch::optim::Adam& optimizer, const Network& network, int64_t steps);

}  // namespace ld
