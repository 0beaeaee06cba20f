/* SPDX-License-Identifier: MIT */
// Seconds that ITK's GradientImageFilter takes for uint16 to float vectors, the least of the runs:
//     itk_gradient SIZE RUNS THREADS
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include <itkGradientImageFilter.h>
#include <itkMultiThreaderBase.h>

int main(int argc, char** argv)
{
    if (argc != 4)
        return 2;
    const std::size_t size = std::strtoul(argv[1], nullptr, 10);
    const int runs = std::atoi(argv[2]), threads = std::atoi(argv[3]);
    itk::MultiThreaderBase::SetGlobalMaximumNumberOfThreads(threads);
    itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(threads);
    using Image = itk::Image<unsigned short, 3>;
    auto image = Image::New();
    image->SetRegions(Image::SizeType{{size, size, size}});
    image->Allocate();
    unsigned short* voxels = image->GetBufferPointer();
    for (std::size_t i = 0; i < size * size * size; ++i)
        voxels[i] = static_cast<unsigned short>((i * 2654435761u) >> 8);
    auto filter = itk::GradientImageFilter<Image, float, float>::New();
    filter->SetInput(image);
    filter->SetUseImageDirection(false); // the identity
    double best = 1e30;
    for (int run = 0; run < runs; ++run) {
        filter->Modified();
        const auto start = std::chrono::steady_clock::now();
        filter->Update();
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        best = seconds.count() < best ? seconds.count() : best;
    }
    const auto g = filter->GetOutput()->GetPixel({{1, 1, 1}});
    const std::size_t at = (size + 1) * size + 1;
    const double wanted = 0.5 * (double(voxels[at + 1]) - double(voxels[at - 1]));
    if (!(std::abs(g[0] - wanted) <= 1e-3 * 65535))
        return std::fprintf(stderr, "itk_gradient: %g at (1, 1, 1), wanted %g\n", g[0], wanted), 1;
    std::printf("%.6f\n", best);
    return 0;
}
