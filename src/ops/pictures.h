// The memory of a batch, picture by picture, for the loops that know nothing of tensors.
#pragma once

#include <torch/torch.h>

namespace ld {

/// pictures[b] points at the elements of batch entry b of a contiguous tensor; null for an undefined tensor.
template <class T>
class Pictures {
 public:
  explicit Pictures(const torch::Tensor& batch)
      : data_(batch.defined() ? batch.data_ptr<T>() : nullptr),
        stride_(batch.defined() ? batch.stride(0) : 0) {}

  T* operator[](int64_t b) const { return data_ == nullptr ? nullptr : data_ + b * stride_; }

 private:
  T* data_;
  int64_t stride_;
};

}  // namespace ld
