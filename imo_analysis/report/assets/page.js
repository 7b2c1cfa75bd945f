(function(){
"use strict";
var all=function(s,r){return Array.prototype.slice.call((r||document).querySelectorAll(s));};
// Opening an entry that a link points to.
function open(){
  var id=decodeURIComponent(location.hash.slice(1)), e=id&&document.getElementById(id);
  if(e&&e.tagName==="DETAILS"){e.hidden=false;e.open=true;e.scrollIntoView();}
}
addEventListener("hashchange",open); open();
// On paper everything is open.
var closed=[];
addEventListener("beforeprint",function(){closed=all("details:not([open])");closed.forEach(function(e){e.open=true;});});
addEventListener("afterprint",function(){closed.forEach(function(e){e.open=false;});closed=[];});
// Choosing entries by verdict and by word.
var tools=document.getElementById("ledger-tools");
if(tools){
  var entries=all("details.entry"), word=tools.querySelector("input"), chosen="";
  var show=function(){
    var w=word.value.trim().toLowerCase(), n=0;
    entries.forEach(function(e){
      var on=(!chosen||e.dataset.verdict===chosen)&&(!w||e.textContent.toLowerCase().indexOf(w)>=0);
      e.hidden=!on; if(on)n++;
    });
    tools.querySelector("output").textContent=n+" of "+entries.length+" shown";
  };
  all("button[data-verdict]",tools).forEach(function(b){
    b.addEventListener("click",function(){
      chosen=b.dataset.verdict;
      all("button[data-verdict]",tools).forEach(function(o){o.setAttribute("aria-pressed",o===b);});
      show();
    });
  });
  word.addEventListener("input",show);
  tools.querySelector("button.expand").addEventListener("click",function(){
    var any=entries.some(function(e){return !e.hidden&&!e.open;});
    entries.forEach(function(e){if(!e.hidden)e.open=any;});
  });
  all("a.tile").forEach(function(a){
    a.addEventListener("click",function(){
      var b=tools.querySelector('button[data-verdict="'+a.dataset.verdict+'"]'); if(b)b.click();
    });
  });
  show();
}
// Poles at one speed, chosen with a slider.
all(".slider").forEach(function(box){
  var d=JSON.parse(box.querySelector("script").textContent), svg=box.querySelector("svg"), range=box.querySelector("input");
  var W=Math.min(720,Math.max(340,svg.clientWidth||720)),H=Math.max(300,W*0.58),L=64,R=16,T=14,B=46,NS="http://www.w3.org/2000/svg";
  var x0=d.re[0],x1=d.re[1],y0=d.im[0],y1=d.im[1];
  var X=function(v){return L+(v-x0)/(x1-x0)*(W-L-R);}, Y=function(v){return T+(y1-v)/(y1-y0)*(H-T-B);};
  svg.setAttribute("viewBox","0 0 "+W+" "+H);
  function el(n,a,t){var e=document.createElementNS(NS,n);for(var k in a)e.setAttribute(k,a[k]);if(t!==undefined)e.textContent=t;svg.appendChild(e);return e;}
  function step(s){var p=Math.pow(10,Math.floor(Math.log10(s/5))),m=s/5/p;return p*(m<1.5?1:m<3.5?2:m<7.5?5:10);}
  function ticks(a,b){var s=step(b-a),o=[],v=Math.ceil(a/s)*s;for(;v<=b+1e-9;v+=s)o.push(Math.round(v*1e6)/1e6);return o;}
  ticks(x0,x1).forEach(function(v){
    el("line",{x1:X(v),x2:X(v),y1:T,y2:H-B,stroke:v===0?"#444":"#ddd"});
    el("text",{x:X(v),y:H-B+16,"font-size":12,"text-anchor":"middle",fill:"#333"},v);
  });
  ticks(y0,y1).forEach(function(v){
    el("line",{x1:L,x2:W-R,y1:Y(v),y2:Y(v),stroke:v===0?"#444":"#ddd"});
    el("text",{x:L-6,y:Y(v)+4,"font-size":12,"text-anchor":"end",fill:"#333"},v);
  });
  el("text",{x:(L+W-R)/2,y:H-8,"font-size":13,"text-anchor":"middle",fill:"#333"},"real part (1/s)");
  el("text",{x:16,y:(T+H-B)/2,"font-size":13,"text-anchor":"middle",fill:"#333",transform:"rotate(-90 16 "+(T+H-B)/2+")"},"imaginary part (rad/s)");
  var marks=d.series.map(function(s){
    return s.poles[0].map(function(){
      if(s.mark==="s")return el("rect",{width:9,height:9,fill:"none",stroke:s.color,"stroke-width":2});
      if(s.mark==="^")return el("path",{d:"M-5,4L5,4L0,-6Z",fill:"none",stroke:s.color,"stroke-width":2});
      if(s.mark==="D")return el("path",{d:"M-6,0L0,-6L6,0L0,6Z",fill:"none",stroke:s.color,"stroke-width":2});
      if(s.mark==="P")return el("path",{d:"M-6,0H6M0,-6V6",fill:"none",stroke:s.color,"stroke-width":2});
      return el("circle",{r:5,fill:"none",stroke:s.color,"stroke-width":2});
    });
  });
  var out=box.querySelector("output"), say=box.querySelector(".say");
  function draw(){
    var k=+range.value; out.textContent=d.omega[k]+" rad/s";
    d.series.forEach(function(s,j){
      s.poles[k].forEach(function(p,i){
        var m=marks[j][i],x=X(p[0]),y=Y(p[1]);
        var off=p[0]<x0||p[0]>x1||p[1]<y0||p[1]>y1; m.style.display=off?"none":"";
        if(s.mark==="o"){m.setAttribute("cx",x);m.setAttribute("cy",y);}
        else if(s.mark==="s"){m.setAttribute("x",x-4.5);m.setAttribute("y",y-4.5);}
        else m.setAttribute("transform","translate("+x+","+y+")");
      });
    });
    say.textContent=d.series.map(function(s){
      var worst=Math.max.apply(null,s.poles[k].map(function(p){return p[0];}));
      return s.label+": rightmost pole at "+worst.toFixed(2)+" /s"+(worst>0.005?" (unstable)":"");
    }).join("; ")+".";
  }
  range.min=0;range.max=d.omega.length-1;range.addEventListener("input",draw);draw();
});
})();
