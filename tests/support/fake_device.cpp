#include "tests/support/fake_device.h"

#include <ATen/EmptyTensor.h>
#include <ATen/core/LegacyTypeDispatch.h>
#include <ATen/ops/_reshape_alias_native.h>
#include <ATen/ops/as_strided_native.h>
#include <ATen/ops/view_native.h>
#include <c10/core/Allocator.h>
#include <c10/core/impl/DeviceGuardImplInterface.h>
#include <sys/mman.h>
#include <torch/library.h>
#include <torch/version.h>

#include <algorithm>
#include <vector>

namespace ld {
namespace {

using torch::Tensor;

const torch::Device kFake(torch::kXPU, 0);

/// What tensors show as their memory, and what is behind it.
class Block {
 public:
  explicit Block(size_t bytes)
      : bytes_(std::max<size_t>(bytes, 1)),
        shown_(mmap(nullptr, bytes_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0)),
        hidden_(bytes_ / sizeof(double) + 1) {
    TORCH_CHECK(shown_ != MAP_FAILED, "fake device: no address for ", bytes, " bytes");
  }
  ~Block() { munmap(shown_, bytes_); }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  void* shown() const { return shown_; }
  char* hidden() { return reinterpret_cast<char*>(hidden_.data()); }

 private:
  size_t bytes_;
  void* shown_;
  std::vector<double> hidden_;  // aligned for all types
};

class FakeAllocator : public c10::Allocator {
 public:
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 3)
  c10::DataPtr allocate(size_t bytes) override {
    return block(bytes);
  }
  void copy_data(void*, const void*, size_t) const override {
    TORCH_CHECK(false, "fake device: a raw copy");
  }
#else
  c10::DataPtr allocate(size_t bytes) const override {
    return block(bytes);
  }
#endif

 private:
  static c10::DataPtr block(size_t bytes) {
    auto* made = new Block(bytes);
    return {made->shown(), made, [](void* old) { delete static_cast<Block*>(old); }, kFake};
  }
};

FakeAllocator& allocator() {
  static FakeAllocator one;
  return one;
}

/// There is one of it, and it does all at once.
struct FakeGuard final : c10::impl::DeviceGuardImplInterface {
  c10::DeviceType type() const override { return kFake.type(); }
  c10::Device exchangeDevice(c10::Device) const override { return kFake; }
  c10::Device getDevice() const override { return kFake; }
  void setDevice(c10::Device) const override {}
  void uncheckedSetDevice(c10::Device) const noexcept override {}
  c10::Stream getStream(c10::Device) const noexcept override {
    return c10::Stream(c10::Stream::DEFAULT, kFake);
  }
  c10::Stream getDefaultStream(c10::Device) const override { return getStream(kFake); }
  c10::Stream exchangeStream(c10::Stream) const noexcept override { return getStream(kFake); }
  c10::DeviceIndex deviceCount() const noexcept override { return 1; }
};
C10_REGISTER_GUARD_IMPL(XPU, FakeGuard)

const c10::DispatchKeySet kKeys(c10::DispatchKey::XPU);

Tensor empty(at::IntArrayRef size, c10::optional<at::ScalarType> type, c10::optional<at::Layout>,
             c10::optional<at::Device>, c10::optional<bool>, c10::optional<at::MemoryFormat> format) {
  return at::detail::empty_generic(size, &allocator(), kKeys, type.value_or(torch::kFloat32), format);
}

Tensor empty_strided(at::IntArrayRef size, at::IntArrayRef stride, c10::optional<at::ScalarType> type,
                     c10::optional<at::Layout>, c10::optional<at::Device>, c10::optional<bool>) {
  return at::detail::empty_strided_generic(size, stride, &allocator(), kKeys, type.value_or(torch::kFloat32));
}

/// The memory behind a tensor, as one of the CPU. A tensor of the CPU is itself.
Tensor behind(const Tensor& tensor) {
  if (tensor.is_cpu()) return tensor;
  const c10::Storage& storage = tensor.storage();
  auto* block = static_cast<Block*>(storage.data_ptr().get_context());
  char* data = block->hidden() + tensor.storage_offset() * static_cast<int64_t>(tensor.element_size());
  return at::from_blob(
      data, tensor.sizes(), tensor.strides(), [storage](void*) {},
      at::TensorOptions().dtype(tensor.dtype()).device(torch::kCPU));
}

/// Also from one device to the other.
Tensor& copy(Tensor& to, const Tensor& from, bool) {
  behind(to).copy_(behind(from));
  return to;
}

Tensor taken_here(const Tensor& result) {
  if (!result.defined()) return result;
  const Tensor here =
      empty_strided(result.sizes(), result.strides(), result.scalar_type(), {}, kFake, c10::nullopt);
  behind(here).copy_(result);
  return here;
}

/// An argument as the CPU's operator takes it.
Tensor argument(const c10::FunctionSchema& schema, const Tensor& given, bool written) {
  if (!given.defined()) return given;
  TORCH_CHECK(!given.is_cpu() || given.dim() == 0, "fake device: ", schema.name(),
              " has a tensor of the CPU among its arguments, of shape ", given.sizes());
  // What is written and empty grows.
  return written && given.numel() == 0 ? at::empty({0}, given.options().device(torch::kCPU)) : behind(given);
}

bool is_written(const c10::AliasInfo* alias) {
  return alias != nullptr && alias->isWrite();
}

/// Which argument a result is; they are matched by the names of what they alias.
size_t written_argument(const c10::FunctionSchema& schema, const c10::AliasInfo& result) {
  const auto& arguments = schema.arguments();
  for (size_t i = 0; i < arguments.size(); ++i)
    if (is_written(arguments[i].alias_info()) &&
        arguments[i].alias_info()->beforeSets() == result.beforeSets())
      return i;
  TORCH_CHECK(false, "fake device: ", schema.name(), " returns a view, and has no form of its own here");
}

/// Any operator, by that of the CPU on the memory behind its arguments.
void on_cpu(const c10::OperatorHandle& op, torch::jit::Stack* stack) {
  const at::AutoDispatchBelowAutograd without_graph;
  const c10::FunctionSchema& schema = op.schema();
  const size_t count = schema.arguments().size(), first = stack->size() - count;
  const std::vector<c10::IValue> given(stack->begin() + static_cast<int64_t>(first), stack->end());
  for (size_t i = 0; i < count; ++i) {
    c10::IValue& value = (*stack)[first + i];
    const bool written = is_written(schema.arguments()[i].alias_info());
    if (value.isTensor()) {
      value = argument(schema, value.toTensor(), written);
    } else if (value.isTensorList()) {
      c10::List<Tensor> list;
      for (const Tensor& tensor : value.toTensorVector()) list.push_back(argument(schema, tensor, written));
      value = std::move(list);
    } else if (value.isList() && value.toList().elementType()->isSubtypeOf(*c10::OptionalType::ofTensor())) {
      c10::List<c10::optional<Tensor>> list;
      for (const c10::IValue& element : value.toListRef())
        list.push_back(element.isNone() ? c10::optional<Tensor>()
                                        : c10::optional<Tensor>(argument(schema, element.toTensor(), false)));
      value = std::move(list);
    } else if (value.isDevice()) {
      value = torch::Device(torch::kCPU);
    }
  }
  // LibTorch 1.13 takes the arguments from the stack before it has copied the results that refer to them.
  const std::vector<c10::IValue> kept(stack->begin() + static_cast<int64_t>(first), stack->end());
  op.callBoxed(stack);

  const size_t results = schema.returns().size(), first_result = stack->size() - results;
  for (size_t i = 0; i < results; ++i) {
    c10::IValue& value = (*stack)[first_result + i];
    if (const c10::AliasInfo* alias = schema.returns()[i].alias_info()) {
      const Tensor& own = given[written_argument(schema, *alias)].toTensor();
      const Tensor result = value.toTensor();
      if (own.sizes() != result.sizes())
        own.unsafeGetTensorImpl()->shallow_copy_from(taken_here(result).getIntrusivePtr());
      value = own;
    } else if (value.isTensor()) {
      value = taken_here(value.toTensor());
    } else if (value.isTensorList()) {
      c10::List<Tensor> list;
      for (const Tensor& tensor : value.toTensorVector()) list.push_back(taken_here(tensor));
      value = std::move(list);
    }
  }
}

TORCH_LIBRARY_IMPL(_, XPU, library) {
  library.fallback(torch::CppFunction::makeFromBoxedFunction<&on_cpu>());
}

TORCH_LIBRARY_IMPL(aten, XPU, library) {
  library.impl("empty.memory_format", &empty);
  library.impl("empty_strided", &empty_strided);
  library.impl("copy_", &copy);
  library.impl("as_strided", &at::native::as_strided_tensorimpl);
  library.impl("view", static_cast<Tensor (*)(const Tensor&, at::IntArrayRef)>(&at::native::view));
  library.impl("_reshape_alias", &at::native::_reshape_alias);
  // LibTorch has a form of these for all devices, which asks each for further operators.
  library.impl("convolution", torch::CppFunction::makeFromBoxedFunction<&on_cpu>());
  library.impl("convolution_backward", torch::CppFunction::makeFromBoxedFunction<&on_cpu>());
}

}  // namespace

torch::Device fake_device() {
  return kFake;
}

}  // namespace ld
