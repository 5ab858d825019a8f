# Finds LibTorch, Debian's or one's own (-DCMAKE_PREFIX_PATH=FOLDER): sets TORCH_LIBRARIES and TORCH_INCLUDE_DIRS as find_package(Torch) does,
# and LD_OWN_TORCH where it has its own copies of other libraries inside.

# PyPI's LibTorch for x86-64 is built with CUDA. Its own configuration asks for NVIDIA's compiler, which nothing here needs. The part for GPUs
# registers itself when it is loaded: nothing refers to it, so the linker would leave it out.
find_path(LD_TORCH_CONFIG TorchConfig.cmake HINTS ${Torch_DIR} ${CMAKE_PREFIX_PATH} ENV CMAKE_PREFIX_PATH
          PATH_SUFFIXES share/cmake/Torch Torch NO_DEFAULT_PATH)
get_filename_component(torch_folder "${LD_TORCH_CONFIG}/../../.." ABSOLUTE)
if(LD_TORCH_CONFIG AND EXISTS ${torch_folder}/lib/libtorch_cuda.so)
  set(TORCH_LIBRARIES -Wl,--push-state,--no-as-needed,${torch_folder}/lib/libtorch_cuda.so,--pop-state
      ${torch_folder}/lib/libtorch_cpu.so ${torch_folder}/lib/libc10.so)
  set(TORCH_INCLUDE_DIRS ${torch_folder}/include ${torch_folder}/include/torch/csrc/api/include)
  add_compile_definitions(USE_DISTRIBUTED USE_C10D_GLOO)
  file(GLOB gomp ${torch_folder}/lib/libgomp*.so*)
  set(OpenMP_gomp_LIBRARY ${gomp} CACHE FILEPATH "LibTorch's, or a process would have two pools of threads")
  file(STRINGS ${LD_TORCH_CONFIG}/TorchConfig.cmake standard REGEX "target_compile_features.*cxx_std_")
  if(standard MATCHES "cxx_std_([0-9]+)")
    set(CMAKE_CXX_STANDARD ${CMAKE_MATCH_1})
  endif()
  message(STATUS "LibTorch: ${torch_folder}, built with CUDA; C++${CMAKE_CXX_STANDARD}")
else()
  find_package(Torch REQUIRED)
endif()

# A LibTorch that is not Debian's brings headers of its own copies of some libraries. Those that Debian's libraries were built with come first.
list(GET TORCH_INCLUDE_DIRS 0 torch_headers)
file(REAL_PATH ${torch_headers} torch_headers)
if(EXISTS ${torch_headers}/fmt AND NOT torch_headers STREQUAL /usr/include)
  set(LD_OWN_TORCH TRUE)
  set(CMAKE_INSTALL_RPATH ${torch_headers}/../lib) # the loader would not find it for what is installed
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/headers)
  foreach(library fmt google)
    file(CREATE_LINK /usr/include/${library} ${CMAKE_BINARY_DIR}/headers/${library} SYMBOLIC)
  endforeach()
  list(PREPEND TORCH_INCLUDE_DIRS ${CMAKE_BINARY_DIR}/headers)
endif()
