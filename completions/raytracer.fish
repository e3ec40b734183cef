# Completions of raytracer for fish. Made from the flags by `cargo run --example shell_files`.

# Whether the word is the value with this index, counted from 0, of the flag, or with * any value of it.
function __raytracer_is_value
    set -l words (commandline -opc)
    set -l count 0
    for word in $words[-1..2]
        if string match -qr -- '^--?[a-zA-Z]' $word
            test (string replace -r -- '^--?' '' $word) = $argv[1]
            and contains -- $argv[2] '*' $count
            return
        end
        set count (math $count + 1)
    end
    return 1
end

# The files that fish itself offers and that have one of these extensions, in any case, and folders.
function __raytracer_files
    set -l endings / '\.'$argv
    complete -C "__raytracer_no_command "(commandline -ct) | string match -ri -- '^.*(?:'(string join '|' $endings)')$'
end

complete -c raytracer -f
complete -c raytracer -o input -d 'The scene; - reads it from standard input'
complete -c raytracer -o output -d 'Writes the picture as .tga, .png, .bmp, .ppm, .pfm or .exr'
complete -c raytracer -o depth -d 'Writes a picture of distances: white at t0 and nearer, black at t1 and beyond'
complete -c raytracer -o normals -d 'Writes a picture of surface normals: |x|, |y|, |z| as red, green, blue'
complete -c raytracer -o normal -d 'Writes a picture of surface normals: |x|, |y|, |z| as red, green, blue'
complete -c raytracer -o render_samples -d 'Writes a picture of the sample positions, with each pixel enlarged'
complete -c raytracer -o render_filter -d 'Writes a picture of the filter\'s weights, with each pixel enlarged'
complete -c raytracer -o region -d 'Renders only this part of every picture, w by h pixels from column x and row y, with the same bytes as in the whole'
complete -c raytracer -o merge -d 'Joins parts written by -region into -output, in any order'
complete -c raytracer -o convert -d 'Converts the picture to the 8-bit format given by -output'
complete -c raytracer -o size -d 'Width and height of every picture in pixels, 1 to 65535'
complete -c raytracer -o edition -d 'Reads scene and flags as in this edition of the course'
complete -c raytracer -o uv -d 'Draws a UV gradient instead of the scene: red = x, green = y, blue = 1'
complete -c raytracer -o shade_back -d 'Lights surfaces seen from behind; without it they are black'
complete -c raytracer -o shadows -d 'Casts shadows'
complete -c raytracer -o no_shadows -d 'Casts no shadows, which is the default'
complete -c raytracer -o transparent_shadows -d 'Casts shadows that transparent objects tint'
complete -c raytracer -o bounces -d 'Follows reflected and refracted rays up to n times'
complete -c raytracer -o weight -d 'Drops reflected and refracted rays whose weight is w or less'
complete -c raytracer -o random_samples -d 'Takes n random samples per pixel, 1 to 65536'
complete -c raytracer -o uniform_samples -d 'Takes n samples per pixel at the centres of a grid\'s cells'
complete -c raytracer -o regular_samples -d 'Takes a regular grid of n samples'
complete -c raytracer -o jittered_samples -d 'Takes n samples per pixel, which smooths edges'
complete -c raytracer -o sobol_samples -d 'Takes n samples per pixel, the first points of a scrambled Sobol\' sequence'
complete -c raytracer -o adaptive_samples -d 'Adaptive sampling: takes at most n samples per pixel, 4 to 1024, until the estimated error of the picture is this many levels (1/255)'
complete -c raytracer -o jitter -d 'Renders three times the width and height, with one random sample in each pixel'
complete -c raytracer -o filter -d 'Blurs the picture and reduces its width and height to a third'
complete -c raytracer -o seed -d 'Seeds the random numbers as srand48(n) does'
complete -c raytracer -o box_filter -d 'Averages the samples within r pixels along both axes'
complete -c raytracer -o tent_filter -d 'Weights samples linearly, down to 0 at the radius r'
complete -c raytracer -o gaussian_filter -d 'Weights samples by a Gaussian of standard deviation s'
complete -c raytracer -o mitchell_filter -d 'Weights samples by Mitchell and Netravali\'s cubic, scaled to end at r; 2 is usual'
complete -c raytracer -o grid -d 'Traces rays through a grid of nx by ny by nz cells'
complete -c raytracer -o visualize_grid -d 'Draws the grid\'s occupied cells instead of the scene'
complete -c raytracer -o visualize_grid_count -d 'Draws the grid\'s occupied cells instead of the scene'
complete -c raytracer -o compare -d 'Compares this picture with the reference'
complete -c raytracer -o reference -d 'The picture to compare with, or the folder of pictures for -grade'
complete -c raytracer -o difference -d 'Draws the picture, the reference and their amplified difference side by side'
complete -c raytracer -o tolerance -d 'Ends with status 3 if more than n pixels differ by more than this many levels (1/255)'
complete -c raytracer -o grade -d 'Grades a class: compares the pictures in each subfolder with the references that -reference or -commands names'
complete -c raytracer -o commands -d 'Renders the references for -grade with the command lines in this file'
complete -c raytracer -o student -d 'Grades only this subfolder of -grade'
complete -c raytracer -o report -d 'Writes the result of -grade as a page, .html, and beside it as a table, .csv'
complete -c raytracer -o error_report -d 'Measures time and error with other samples, filters, bounces and grids'
complete -c raytracer -o target -d 'Prints the fastest measured setting with a root mean square error of at most this, in levels (1/255)'
complete -c raytracer -o stats -d 'Prints counters and times after rendering'
complete -c raytracer -o repeat -d 'Renders n times, 1 to 10000, and prints the least time, the median and the spread (maximum minus minimum)'
complete -c raytracer -o cost_map -d 'Draws the cost of each pixel as a heat map'
complete -c raytracer -o pixel -d 'Prints the rays behind one pixel, and what each of them hits'
complete -c raytracer -o gui -d 'Renders, then shows the scene as a live page in the browser'
complete -c raytracer -o port -d 'Serves the page of -gui at this port of 127.0.0.1, also without a terminal'
complete -c raytracer -o no_browser -d 'Prints the page\'s address and opens no browser'
complete -c raytracer -o tessellation -d 'Accepted from the course; changes nothing'
complete -c raytracer -o gouraud -d 'Accepted from the course; changes nothing'
complete -c raytracer -o specular_fix -d 'Accepted from Aalto\'s edition, whose program ignores it; changes nothing'
complete -c raytracer -o json -d 'Writes everything that the run reports to a .json file; - writes it to standard output instead of the text'
complete -c raytracer -o threads -d 'Renders with n threads, 1 to 4096'
complete -c raytracer -o progress -d 'Prints the progress every ten seconds if standard error is not a terminal'
complete -c raytracer -o show_progress -d 'Prints the progress every ten seconds if standard error is not a terminal'
complete -c raytracer -o quiet -d 'Prints neither the progress nor, on a terminal, the names of the files written'
complete -c raytracer -o strict -d 'Treats warnings as errors: the run ends with status 1 and writes no picture'
complete -c raytracer -o h -d 'Prints the ten most common flags'
complete -c raytracer -o help -d 'Lists all flags'
complete -c raytracer -o version -d 'Prints the version'
complete -c raytracer -n '__raytracer_is_value input 0' -a '(__raytracer_files txt)'
complete -c raytracer -n '__raytracer_is_value output 0' -a '(__raytracer_files tga png bmp ppm pfm exr)'
complete -c raytracer -n '__raytracer_is_value depth 2' -a '(__raytracer_files tga png bmp ppm pfm exr)'
complete -c raytracer -n '__raytracer_is_value normals 0' -a '(__raytracer_files tga png bmp ppm pfm exr)'
complete -c raytracer -n '__raytracer_is_value normal 0' -a '(__raytracer_files tga png bmp ppm pfm exr)'
complete -c raytracer -n '__raytracer_is_value render_samples 0' -a '(__raytracer_files tga png bmp ppm pfm exr)'
complete -c raytracer -n '__raytracer_is_value render_filter 0' -a '(__raytracer_files tga png bmp ppm pfm exr)'
complete -c raytracer -n '__raytracer_is_value merge \*' -a '(__raytracer_files tga png)'
complete -c raytracer -n '__raytracer_is_value convert 0' -a '(__raytracer_files tga png bmp ppm pgm pbm pnm pam pfm exr)'
complete -c raytracer -n '__raytracer_is_value edition 0' -a '2004 2012a4 2012a5 2019 aalto'
complete -c raytracer -n '__raytracer_is_value grid 0' -a 'auto none'
complete -c raytracer -n '__raytracer_is_value compare 0' -a '(__raytracer_files tga png bmp ppm pgm pbm pnm pam pfm exr)'
complete -c raytracer -n '__raytracer_is_value reference 0' -a '(__raytracer_files tga png bmp ppm pgm pbm pnm pam pfm exr)'
complete -c raytracer -n '__raytracer_is_value difference 0' -a '(__raytracer_files tga png bmp ppm pfm exr)'
complete -c raytracer -n '__raytracer_is_value grade 0' -a '(__raytracer_files)'
complete -c raytracer -n '__raytracer_is_value commands 0' -a '(__raytracer_files txt)'
complete -c raytracer -n '__raytracer_is_value report 0' -a '(__raytracer_files html)'
complete -c raytracer -n '__raytracer_is_value error_report 0' -a '(__raytracer_files)'
complete -c raytracer -n '__raytracer_is_value cost_map 0' -a 'rays tests cells'
complete -c raytracer -n '__raytracer_is_value cost_map 1' -a '(__raytracer_files tga png bmp ppm pfm exr)'
complete -c raytracer -n '__raytracer_is_value json 0' -a '(__raytracer_files json)'
