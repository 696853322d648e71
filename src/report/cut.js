// The cut through the mesh, which follows the slider.
const cut = document.getElementById("cut");
if (slider && cut) {
  unpacked(document.getElementById("cuts").textContent).then((bytes) => {
    const pictures = new TextDecoder().decode(bytes).split("\n");
    const remark = document.getElementById("cut-step");
    let drawn = 0;
    const follow = (stop) => {
      const picture = pictureOf[stop];
      const isOther = data.frames[picture] !== data.stops[stop];
      remark.textContent = isOther ? `Shown is step ${data.steps[picture]}, the nearest with a picture.` : "";
      if (picture === drawn) return;
      drawn = picture;
      cut.innerHTML = pictures[picture];
    };
    followers.push(follow);
    follow(Number(slider.value));
    cut.dataset.ready = pictures.length;
  }).catch((error) => {
    document.getElementById("cut-step").textContent = `The cut stays at the first step: ${error.message}.`;
  });
}
