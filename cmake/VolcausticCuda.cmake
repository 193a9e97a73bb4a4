# Decides whether the CUDA backend is built, and defines VOLCAUSTIC_HAS_CUDA for the rest of the build.
set(VOLCAUSTIC_HAS_CUDA OFF)
if(NOT VOLCAUSTIC_CUDA STREQUAL "OFF")
  if(NOT CMAKE_CUDA_ARCHITECTURES)
    # Machine code for the chips that matter, and PTX of 90 and of the newest for those between and after them. A toolkit
    # that does not know one (12 does not know 120, for example) needs a shorter list.
    set(CMAKE_CUDA_ARCHITECTURES 75-real 80-real 86-real 90 100-real 120)
  endif()
  include(CheckLanguage)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    enable_language(CUDA)
    # CMake 3.25 does not know how nvcc is told the C++20 that CMAKE_CXX_STANDARD asks for.
    if(NOT DEFINED CMAKE_CUDA20_STANDARD_COMPILE_OPTION)
      set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION -std=c++20)
      set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION -std=c++20)
    endif()
    target_compile_options(volcaustic_settings INTERFACE
      $<$<COMPILE_LANGUAGE:CUDA>:--expt-relaxed-constexpr>
      $<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<BOOL:${VOLCAUSTIC_PARITY}>>:-fmad=false>
      $<$<AND:$<COMPILE_LANGUAGE:CUDA>,$<BOOL:${VOLCAUSTIC_WERROR}>>:--Werror=all-warnings>)
    find_package(CUDAToolkit REQUIRED)
    set(VOLCAUSTIC_HAS_CUDA ON)
  elseif(VOLCAUSTIC_CUDA STREQUAL "ON")
    message(FATAL_ERROR "VOLCAUSTIC_CUDA=ON, but no nvcc was found. Put it on PATH, set CUDACXX, or use VOLCAUSTIC_CUDA=AUTO.")
  endif()
endif()
message(STATUS "volcaustic: CUDA backend ${VOLCAUSTIC_HAS_CUDA}")
