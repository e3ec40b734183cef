# Completions of raytracer for bash. Made from the flags by `cargo run --example shell_files`.

# Offers the files with these extensions in any case, and folders.
_raytracer_files() {
    local current=$1 extension name
    shift
    for extension; do
        while IFS= read -r name; do COMPREPLY+=("$name"); done < <(
            shopt -s nocasematch
            compgen -f -X "!*.$extension" -- "$current"
        )
    done
    while IFS= read -r name; do COMPREPLY+=("$name"); done < <(compgen -d -- "$current")
    compopt -o filenames 2>/dev/null
}

_raytracer() {
    local current=${COMP_WORDS[COMP_CWORD]} flag= count=0 i
    COMPREPLY=()
    # The last flag before the word, and the number of values between.
    for ((i = COMP_CWORD - 1; i > 0; i--)); do
        case ${COMP_WORDS[i]} in
            -[a-zA-Z]* | --[a-zA-Z]*)
                flag=${COMP_WORDS[i]#-}
                flag=${flag#-}
                break
                ;;
        esac
        count=$((count + 1))
    done
    if [[ $current != -[a-zA-Z]* ]]; then
        case $flag:$count in
            input:0) _raytracer_files "$current" txt; return ;;
            output:0) _raytracer_files "$current" tga png bmp ppm pfm exr; return ;;
            depth:0) return ;;
            depth:1) return ;;
            depth:2) _raytracer_files "$current" tga png bmp ppm pfm exr; return ;;
            normals:0 | normal:0) _raytracer_files "$current" tga png bmp ppm pfm exr; return ;;
            render_samples:0) _raytracer_files "$current" tga png bmp ppm pfm exr; return ;;
            render_samples:1) return ;;
            render_filter:0) _raytracer_files "$current" tga png bmp ppm pfm exr; return ;;
            render_filter:1) return ;;
            region:0) return ;;
            region:1) return ;;
            region:2) return ;;
            region:3) return ;;
            merge:*) _raytracer_files "$current" tga png; return ;;
            convert:0) _raytracer_files "$current" tga png bmp ppm pgm pbm pnm pam pfm exr; return ;;
            size:0) return ;;
            size:1) return ;;
            edition:0) COMPREPLY=($(compgen -W '2004 2012a4 2012a5 2019 aalto' -- "$current")); return ;;
            bounces:0) return ;;
            weight:0) return ;;
            random_samples:0) return ;;
            uniform_samples:0) return ;;
            regular_samples:0) return ;;
            jittered_samples:0) return ;;
            sobol_samples:0) return ;;
            adaptive_samples:0) return ;;
            adaptive_samples:1) return ;;
            seed:0) return ;;
            box_filter:0) return ;;
            tent_filter:0) return ;;
            gaussian_filter:0) return ;;
            mitchell_filter:0) return ;;
            grid:0) COMPREPLY=($(compgen -W 'auto none' -- "$current")); return ;;
            grid:1) return ;;
            grid:2) return ;;
            compare:0) _raytracer_files "$current" tga png bmp ppm pgm pbm pnm pam pfm exr; return ;;
            reference:0) _raytracer_files "$current" tga png bmp ppm pgm pbm pnm pam pfm exr; return ;;
            difference:0) _raytracer_files "$current" tga png bmp ppm pfm exr; return ;;
            tolerance:0) return ;;
            tolerance:1) return ;;
            grade:0) _raytracer_files "$current"; return ;;
            commands:0) _raytracer_files "$current" txt; return ;;
            student:0) return ;;
            report:0) _raytracer_files "$current" html; return ;;
            error_report:0) _raytracer_files "$current"; return ;;
            target:0) return ;;
            repeat:0) return ;;
            cost_map:0) COMPREPLY=($(compgen -W 'rays tests cells' -- "$current")); return ;;
            cost_map:1) _raytracer_files "$current" tga png bmp ppm pfm exr; return ;;
            pixel:0) return ;;
            pixel:1) return ;;
            port:0) return ;;
            tessellation:0) return ;;
            tessellation:1) return ;;
            json:0) _raytracer_files "$current" json; return ;;
            threads:0) return ;;
        esac
    fi
    COMPREPLY=($(compgen -W '-input -output -depth -normals -render_samples -render_filter -region -merge -convert -size -edition -uv -shade_back -shadows -no_shadows -transparent_shadows -bounces -weight -random_samples -uniform_samples -regular_samples -jittered_samples -sobol_samples -adaptive_samples -jitter -filter -seed -box_filter -tent_filter -gaussian_filter -mitchell_filter -grid -visualize_grid -compare -reference -difference -tolerance -grade -commands -student -report -error_report -target -stats -repeat -cost_map -pixel -gui -port -no_browser -tessellation -gouraud -specular_fix -json -threads -progress -quiet -strict -h -help -version' -- "$current"))
}

complete -F _raytracer raytracer
